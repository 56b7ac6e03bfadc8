// The life of instances, linked natively so that the leak checker sees every allocation: many instances, saved and
// serialised states that outlive their origin, refused instantiation, NULL instead of an instance.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "fmi2Functions.h"

namespace {

std::string last_message;

void log(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String message, ...) {
    last_message = message;
}

void require(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "failed: %s (last message: %s)\n", what, last_message.c_str());
    std::exit(1);
}

const fmi2CallbackFunctions callbacks{log, std::calloc, std::free, nullptr, nullptr};

fmi2Component started(const std::string& token) {
    fmi2Component c = fmi2Instantiate("it", fmi2CoSimulation, token.c_str(), "", &callbacks, fmi2False, fmi2False);
    require(c != nullptr, "instantiate");
    require(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "setup");
    require(fmi2EnterInitializationMode(c) == fmi2OK, "enter initialization");
    require(fmi2ExitInitializationMode(c) == fmi2OK, "exit initialization");
    return c;
}

}  // namespace

int main() {
    // A refused token names the expected one.
    require(fmi2Instantiate("it", fmi2CoSimulation, "wrong", "", &callbacks, fmi2False, fmi2False) == nullptr,
            "refuse");
    const std::size_t quote = last_message.rfind('{');
    require(quote != std::string::npos, "message names the expected token");
    const std::string token = last_message.substr(quote, last_message.find('}', quote) - quote + 1);
    require(fmi2Instantiate(nullptr, fmi2CoSimulation, token.c_str(), "", &callbacks, 0, 0) == nullptr, "no name");
    require(fmi2Instantiate("it", fmi2CoSimulation, nullptr, "", &callbacks, 0, 0) == nullptr, "no token");
    require(fmi2Instantiate("it", fmi2CoSimulation, token.c_str(), "", nullptr, 0, 0) == nullptr, "no callbacks");
    require(fmi2DoStep(nullptr, 0.0, 0.1, fmi2False) == fmi2Error, "NULL instance");
    fmi2FreeInstance(nullptr);

    std::vector<fmi2Component> instances;
    for (int i = 0; i < 50; ++i) instances.push_back(started(token));
    std::vector<char> bytes;
    for (fmi2Component c : instances) {
        for (int k = 0; k < 20; ++k) require(fmi2DoStep(c, k * 0.05, 0.05, fmi2False) == fmi2OK, "step");
        fmi2FMUstate state = nullptr;
        require(fmi2GetFMUstate(c, &state) == fmi2OK, "save");
        require(fmi2GetFMUstate(c, &state) == fmi2OK, "save again into the same");
        std::size_t size = 0;
        require(fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK, "size");
        bytes.resize(size);
        require(fmi2SerializeFMUstate(c, state, bytes.data(), size) == fmi2OK, "serialise");
        require(fmi2SetFMUstate(c, state) == fmi2OK, "restore");
        require(fmi2FreeFMUstate(c, &state) == fmi2OK && state == nullptr, "free state");
        require(fmi2FreeFMUstate(c, &state) == fmi2OK, "free nothing");
        require(fmi2SetFMUstate(c, nullptr) == fmi2Error, "restore nothing");
        require(fmi2DeSerializeFMUstate(c, bytes.data(), size - 1, &state) == fmi2Error, "too few bytes");
    }
    fmi2FMUstate state = nullptr;
    require(fmi2DeSerializeFMUstate(instances[0], bytes.data(), bytes.size(), &state) == fmi2OK, "deserialise");
    for (fmi2Component c : instances) {
        require(fmi2SetFMUstate(c, state) == fmi2OK, "restore into another instance");
        require(fmi2DoStep(c, 1.0, 0.05, fmi2False) == fmi2OK, "continue");
        require(fmi2Terminate(c) == fmi2OK, "terminate");
        require(fmi2Reset(c) == fmi2OK, "reset");
    }
    fmi2FreeFMUstate(instances[0], &state);
    for (fmi2Component c : instances) fmi2FreeInstance(c);
    std::puts("ok");
    return 0;
}
