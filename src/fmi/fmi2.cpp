// FMI 2.0: the C functions, each a thin step onto Instance.
#include <cstdlib>
#include <cstring>

#include "fmi/entry.hpp"
#include "fmi2Functions.h"

namespace {

using namespace adcs;

struct Component {
    Handle handle;
    fmi2CallbackFunctions callbacks;
    char name[128];
};

void write_log(void* context, Status status, const char* category, const char* message) {
    const auto* component = static_cast<const Component*>(context);
    if (component->callbacks.logger != nullptr) {
        component->callbacks.logger(component->callbacks.componentEnvironment, component->name,
                                    static_cast<fmi2Status>(status), category, message);
    }
}

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    return call(c, mode_any, __func__,
                [&](Instance& instance) { return instance.set_debug_logging(on != fmi2False, n, categories); });
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String /*resources*/,
                              const fmi2CallbackFunctions* functions, fmi2Boolean /*visible*/, fmi2Boolean logging) {
    if (functions == nullptr) return nullptr;
    auto* component = static_cast<Component*>(std::calloc(1, sizeof(Component)));
    if (component == nullptr) return nullptr;
    component->callbacks = *functions;
    std::strncpy(component->name, name == nullptr ? "" : name, sizeof component->name - 1);
    component->handle.instance =
        Instance::create(name, guid, type == fmi2ModelExchange ? Interface::model_exchange : Interface::co_simulation,
                         {write_log, component});
    if (component->handle.instance == nullptr) {
        std::free(component);
        return nullptr;
    }
    component->handle.instance->set_debug_logging(logging != fmi2False, 0, nullptr);
    return component;
}

void fmi2FreeInstance(fmi2Component c) {
    if (c == nullptr) return;
    Instance::destroy(static_cast<Handle*>(c)->instance);
    std::free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean /*toleranceDefined*/, fmi2Real /*tolerance*/,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    return call(c, mode_instantiated, __func__,
                [&](Instance& instance) { return instance.setup(stop_defined != fmi2False, start, stop); });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return call(c, mode_instantiated, __func__, [&](Instance& instance) { return instance.enter_initialization(); });
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return call(c, mode_initialization, __func__, [&](Instance& instance) { return instance.exit_initialization(); });
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return call(c, mode_running, __func__, [&](Instance& instance) { return instance.terminate(); });
}

fmi2Status fmi2Reset(fmi2Component c) {
    return call(c, mode_any, __func__, [&](Instance& instance) { return instance.reset(); });
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.get<Addressing::scalars, Floats>(function, vr, n, value, n);
    });
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.get<Addressing::scalars, fmi2::IntegersAndItems>(function, vr, n, value, n);
    });
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.get<Addressing::scalars, fmi2::Booleans>(function, vr, n, value, n);
    });
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.get<Addressing::scalars, Texts>(function, vr, n, value, n);
    });
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    return call(c, mode_settable, __func__, [&](Instance& instance, const char* function) {
        return instance.set<Addressing::scalars, Floats>(function, vr, n, value, n);
    });
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    return call(c, mode_settable, __func__, [&](Instance& instance, const char* function) {
        return instance.set<Addressing::scalars, fmi2::IntegersAndItems>(function, vr, n, value, n);
    });
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    return call(c, mode_settable, __func__, [&](Instance& instance, const char* function) {
        return instance.set<Addressing::scalars, fmi2::Booleans>(function, vr, n, value, n);
    });
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    return call(c, mode_settable, __func__, [&](Instance& instance, const char* function) {
        return instance.set<Addressing::scalars, Texts>(function, vr, n, value, n);
    });
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return call(c, mode_any, __func__,
                [&](Instance& instance, const char* function) { return instance.save_new(function, state); });
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return call(c, mode_any, __func__,
                [&](Instance& instance, const char* function) { return instance.restore(function, state); });
}
fmi2Status fmi2FreeFMUstate(fmi2Component /*c*/, fmi2FMUstate* state) {
    Instance::free_state(state);
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate /*state*/, size_t* size) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, size)) return Status::error;
        *size = instance.state_size();
        return Status::ok;
    });
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.serialize(function, state, bytes, size);
    });
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    return call(c, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.deserialize(function, bytes, size, state);
    });
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    return call(c, mode_readable, __func__, [&](Instance& instance, const char* function) {
        return instance.differentiate(function, Addressing::scalars, unknowns, n_unknowns, knowns, n_knowns, seed,
                                      n_knowns, sensitivity, n_unknowns);
    });
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return call(c, mode_continuous | mode_event, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.enter_event_mode(); });
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    return call(c, mode_event, Interface::model_exchange, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, info)) return Status::error;
        Discrete discrete;
        const Status status = instance.update_discrete_states(discrete);
        info->newDiscreteStatesNeeded = fmi2False;
        info->terminateSimulation = fmi2False;
        info->nominalsOfContinuousStatesChanged = fmi2False;
        info->valuesOfContinuousStatesChanged = discrete.states_changed ? fmi2True : fmi2False;
        info->nextEventTimeDefined = discrete.next_event_defined ? fmi2True : fmi2False;
        info->nextEventTime = discrete.next_event;
        return status;
    });
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return call(c, mode_event, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.enter_continuous_time(); });
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi2Boolean* enter_event_mode, fmi2Boolean* terminate) {
    return call(c, mode_continuous, Interface::model_exchange, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, enter_event_mode, terminate)) return Status::error;
        *enter_event_mode = *terminate = fmi2False;
        return Status::ok;
    });
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return call(c, mode_event | mode_continuous, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.set_time(time); });
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    return call(c, mode_event | mode_continuous, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.set_states(x, n); });
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    return call(c, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_derivatives(derivatives, n); });
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    return call(c, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_event_indicators(indicators, n); });
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    return call(c, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_states(x, n); });
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    return call(c, mode_any, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_nominals(nominals, n); });
}

// ------------------------------------------------------------------------------------------------- Co-Simulation

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/) {
    return call(c, mode_step, Interface::co_simulation, __func__,
                [&](Instance& instance) { return instance.do_step(time, step); });
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
    return not_supported(c, __func__);
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                        fmi2Real[]) {
    return not_supported(c, __func__);
}
fmi2Status fmi2CancelStep(fmi2Component c) { return not_supported(c, __func__); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) { return not_supported(c, __func__); }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    if (kind != fmi2LastSuccessfulTime) return not_supported(c, __func__);
    constexpr unsigned modes = mode_step | mode_terminated;
    return call(c, modes, Interface::co_simulation, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, value)) return Status::error;
        *value = instance.time();
        return Status::ok;
    });
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
    return not_supported(c, __func__);
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind, fmi2Boolean*) {
    return not_supported(c, __func__);
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) {
    return not_supported(c, __func__);
}

}  // extern "C"
