// Counts the messages that come in by UDP, by their names in mavlink-mappings: node decode_with_node.cjs PORT SECONDS
const dgram = require("node:dgram");
const { PassThrough } = require("node:stream");
const { MavLinkPacketParser, MavLinkPacketSplitter } = require("node-mavlink");
const { minimal, standard, common } = require("mavlink-mappings");

const known = { ...minimal.REGISTRY, ...standard.REGISTRY, ...common.REGISTRY };
const counts = { unknown: 0 };
const input = new PassThrough();
input.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on("data", (packet) => {
  const kind = known[packet.header.msgid];
  if (kind === undefined) {
    counts.unknown += 1;
    return;
  }
  packet.protocol.data(packet.payload, kind);
  counts[kind.name] = (counts[kind.name] ?? 0) + 1;
});
const socket = dgram.createSocket("udp4");
let ending = null;
socket.on("message", (data) => {
  input.write(data);
  ending ??= setTimeout(() => {
    console.log(JSON.stringify(counts));
    process.exit(0);
  }, 1000 * Number(process.argv[3]));
});
socket.bind(Number(process.argv[2]), "127.0.0.1");
