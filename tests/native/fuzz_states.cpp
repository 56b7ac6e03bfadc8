// Damaged saved states. With bits flipped, values replaced or the end cut off, every one must be refused. With the checksum
// made to fit again, as no damage does, what is taken must still not crash, hang or answer OK with a value that is not
// finite.
//
//     fuzz_states_RigidBody TRIES [FIRST_SEED]
#include "fmi/saved_state.hpp"
#include "fuzz.hpp"

namespace {

using namespace fuzz;

struct Count {
    long damaged = 0, forged = 0, forged_refused = 0, forged_taken = 0;
};

void damage(Random& random, std::vector<unsigned char>& bytes) {
    const auto original = bytes;
    while (bytes == original) {
        for (std::size_t n = 1 + random.below(4); n > 0; --n) {
            const bool header = random.chance(0.4);
            const std::size_t from = header ? 16 : sizeof(adcs::SavedHeader);
            const std::size_t to = header ? sizeof(adcs::SavedHeader) : bytes.size();
            if (random.chance(0.4)) {
                const double value = special(random);
                const std::size_t at = from + 8 * random.below((to - from) / 8);
                std::memcpy(bytes.data() + at, &value, sizeof value);
            } else {
                bytes[from + random.below(to - from)] ^= static_cast<unsigned char>(1U << random.below(8));
            }
        }
    }
}

void forge(std::vector<unsigned char>& bytes) {
    const std::uint64_t sum = adcs::saved_checksum(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
    std::memcpy(bytes.data() + offsetof(adcs::SavedHeader, checksum), &sum, sizeof sum);
}

/// Everything that can be done from a state that was taken.
void use(const Subject& subject, Tool& tool) {
    subject.all(tool);
    double time = 0.0;
    if (tool.get(subject.table().variables[0], &time) != 0) return;
    if (tool.cosim()) {
        for (int i = 0; i < 3; ++i) {
            if (tool.step(time, 0.01) != 0) break;
            time += 0.01;
        }
    } else {
        std::vector<double> x(subject.states());
        tool.update();
        tool.enter_continuous();
        if (tool.derivatives(x.data(), x.size()) == 0) {
            for (const double value : x) require(std::isfinite(value), "a derivative is not finite, but OK");
        }
        tool.set_time(time + 0.01);
        tool.enter_event();
        tool.update();
    }
    subject.all(tool);
}

void attempt(const Subject& subject, std::uint64_t seed, Count& count) {
    Random random(seed);
    Tool tool(random.chance(0.5) ? 2 : 3, random.chance(0.6), subject.token());
    for (std::size_t i = random.below(5); i > 0; --i) subject.set_any(random, tool, 0.0);
    const bool entered = tool.enter(random.chance(0.5) ? 0.0 : 1.25, false, 0.0) == 0;
    const bool running = entered && random.chance(0.9) && tool.exit_initialization() == 0;
    double time = 0.0;
    if (running && tool.get(subject.table().variables[0], &time) == 0 && tool.cosim()) tool.step(time, 0.03);
    if (random.chance(0.5)) subject.set_any(random, tool, 0.0);

    void *state = nullptr, *taken = nullptr;
    std::vector<unsigned char> bytes;
    require(tool.save(&state) == 0 && tool.to_bytes(state, bytes) == 0, "save");
    const auto before = subject.all(tool);
    require(tool.restore(state) == 0, "an own state is refused");

    auto damaged = bytes;
    damage(random, damaged);
    ++count.damaged;
    require(tool.from_bytes(damaged, &taken) == 3 && taken == nullptr, "a damaged state is taken");
    damaged.resize(random.below(bytes.size()));
    require(tool.from_bytes(damaged, &taken) == 3, "a cut state is taken");

    auto forged = bytes;
    damage(random, forged);
    forge(forged);
    ++count.forged;
    if (tool.from_bytes(forged, &taken) != 0 || tool.restore(taken) != 0) {
        ++count.forged_refused;
        require(same(before, subject.all(tool)), "a refused state has changed the instance");
    } else {
        ++count.forged_taken;
        use(subject, tool);
    }
    tool.free_state(&taken);
    tool.free_state(&state);
}

}  // namespace

int main(int argc, char** argv) {
    const std::uint64_t tries = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 300;
    const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
    const Subject subject;
    Count count;
    for (std::uint64_t seed = first; seed < first + tries; ++seed) {
        report.seed = seed;
        watch(30);
        attempt(subject, seed, count);
    }
    std::printf(
        "%s: %ld damaged states, all refused; %ld with a checksum that fits, %ld refused, %ld taken and sound\n",
        report.component, count.damaged, count.forged, count.forged_refused, count.forged_taken);
    return 0;
}
