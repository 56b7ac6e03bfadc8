// FMI 3.0: the C functions, each a thin step onto Instance.
#include <cstdlib>
#include <cstring>

#include "fmi/entry.hpp"
#include "fmi3Functions.h"

namespace {

using namespace adcs;

struct Component {
    Handle handle;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
};

void write_log(void* context, Status status, const char* category, const char* message) {
    const auto* component = static_cast<const Component*>(context);
    if (component->log != nullptr) {
        component->log(component->environment, static_cast<fmi3Status>(status), category, message);
    }
}

fmi3Instance instantiate(Interface interface, fmi3String name, fmi3String token, fmi3Boolean logging,
                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    auto* component = static_cast<Component*>(std::calloc(1, sizeof(Component)));
    if (component == nullptr) return nullptr;
    component->environment = environment;
    component->log = log;
    component->handle.instance = Instance::create(name, token, interface, {write_log, component});
    if (component->handle.instance == nullptr) {
        std::free(component);
        return nullptr;
    }
    component->handle.instance->set_debug_logging(logging, 0, nullptr);
    return component;
}

/// Where values are, as the instance takes them: what is not known to be a bool is looked at as a byte.
template <class P, class Value>
auto* passed(Value* values) {
    if constexpr (std::is_const_v<Value>) {
        return reinterpret_cast<const typename P::Value*>(values);
    } else {
        return reinterpret_cast<typename P::Value*>(values);
    }
}
static_assert(sizeof(fmi3Boolean) == sizeof(fmi3::Booleans::Value));

}  // namespace

extern "C" {

const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    return call(i, mode_any, __func__,
                [&](Instance& instance) { return instance.set_debug_logging(on, n, categories); });
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String /*resources*/,
                                          fmi3Boolean /*visible*/, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    return instantiate(Interface::model_exchange, name, token, logging, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String /*resources*/,
                                         fmi3Boolean /*visible*/, fmi3Boolean logging, fmi3Boolean /*eventModeUsed*/,
                                         fmi3Boolean /*earlyReturnAllowed*/, const fmi3ValueReference[], size_t,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback /*update*/) {
    return instantiate(Interface::co_simulation, name, token, logging, environment, log);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                               fmi3UnlockPreemptionCallback) {
    if (log != nullptr) log(environment, fmi3Error, log_categories[0].name, "Scheduled Execution is not supported");
    return nullptr;
}

void fmi3FreeInstance(fmi3Instance i) {
    if (i == nullptr) return;
    Instance::destroy(static_cast<Handle*>(i)->instance);
    std::free(i);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean /*toleranceDefined*/, fmi3Float64 /*tolerance*/,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
    return call(i, mode_instantiated, __func__, [&](Instance& instance) {
        const Status status = instance.setup(stop_defined, start, stop);
        return status == Status::ok ? instance.enter_initialization() : status;
    });
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) {
    return call(i, mode_initialization, __func__, [&](Instance& instance) { return instance.exit_initialization(); });
}
fmi3Status fmi3Terminate(fmi3Instance i) {
    return call(i, mode_running, __func__, [&](Instance& instance) { return instance.terminate(); });
}
fmi3Status fmi3Reset(fmi3Instance i) {
    return call(i, mode_any, __func__, [&](Instance& instance) { return instance.reset(); });
}

#define ADCS_VARIABLES_OF(TYPE, PASSED)                                                                          \
    fmi3Status fmi3Get##TYPE(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3##TYPE values[],       \
                             size_t n_values) {                                                                  \
        return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {                       \
            return instance.get<Addressing::arrays, PASSED>(function, vr, n, passed<PASSED>(values), n_values);  \
        });                                                                                                      \
    }                                                                                                            \
    fmi3Status fmi3Set##TYPE(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3##TYPE values[], \
                             size_t n_values) {                                                                  \
        return call(i, mode_settable, __func__, [&](Instance& instance, const char* function) {                  \
            return instance.set<Addressing::arrays, PASSED>(function, vr, n, passed<PASSED>(values), n_values);  \
        });                                                                                                      \
    }
ADCS_VARIABLES_OF(Float64, Floats)
ADCS_VARIABLES_OF(Int32, Integers)
ADCS_VARIABLES_OF(Int64, fmi3::EnumerationItems)
ADCS_VARIABLES_OF(Boolean, fmi3::Booleans)
ADCS_VARIABLES_OF(String, Texts)
#undef ADCS_VARIABLES_OF

#define ADCS_NO_VARIABLES_OF(TYPE)                                                                                  \
    fmi3Status fmi3Get##TYPE(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3##TYPE[], size_t) {       \
        return none_of_type(i, __func__, n, vr);                                                                    \
    }                                                                                                               \
    fmi3Status fmi3Set##TYPE(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3##TYPE[], size_t) { \
        return none_of_type(i, __func__, n, vr);                                                                    \
    }
ADCS_NO_VARIABLES_OF(Float32)
ADCS_NO_VARIABLES_OF(Int8)
ADCS_NO_VARIABLES_OF(UInt8)
ADCS_NO_VARIABLES_OF(Int16)
ADCS_NO_VARIABLES_OF(UInt16)
ADCS_NO_VARIABLES_OF(UInt32)
ADCS_NO_VARIABLES_OF(UInt64)
#undef ADCS_NO_VARIABLES_OF

fmi3Status fmi3GetBinary(fmi3Instance i, const fmi3ValueReference vr[], size_t n, size_t[], fmi3Binary[], size_t) {
    return none_of_type(i, __func__, n, vr);
}
fmi3Status fmi3SetBinary(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const size_t[], const fmi3Binary[],
                         size_t) {
    return none_of_type(i, __func__, n, vr);
}
fmi3Status fmi3GetClock(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Clock[]) {
    return none_of_type(i, __func__, n, vr);
}
fmi3Status fmi3SetClock(fmi3Instance i, const fmi3ValueReference vr[], size_t n, const fmi3Clock[]) {
    return none_of_type(i, __func__, n, vr);
}

fmi3Status fmi3GetFMUState(fmi3Instance i, fmi3FMUState* state) {
    return call(i, mode_any, __func__,
                [&](Instance& instance, const char* function) { return instance.save_new(function, state); });
}
fmi3Status fmi3SetFMUState(fmi3Instance i, fmi3FMUState state) {
    return call(i, mode_any, __func__,
                [&](Instance& instance, const char* function) { return instance.restore(function, state); });
}
fmi3Status fmi3FreeFMUState(fmi3Instance /*i*/, fmi3FMUState* state) {
    Instance::free_state(state);
    return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState /*state*/, size_t* size) {
    return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, size)) return Status::error;
        *size = instance.state_size();
        return Status::ok;
    });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.serialize(function, state, bytes, size);
    });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
    return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {
        return instance.deserialize(function, bytes, size, state);
    });
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance i, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return call(i, mode_readable, __func__, [&](Instance& instance, const char* function) {
        return instance.differentiate(function, Addressing::arrays, unknowns, n_unknowns, knowns, n_knowns, seed,
                                      n_seed, sensitivity, n_sensitivity);
    });
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance i, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return call(i, mode_readable, __func__, [&](Instance& instance, const char* function) {
        return instance.differentiate_adjoint(function, Addressing::arrays, unknowns, n_unknowns, knowns, n_knowns,
                                              seed, n_seed, sensitivity, n_sensitivity);
    });
}
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t*) {
    return not_supported(i, __func__);
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance i, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                                       fmi3DependencyKind[], size_t) {
    return not_supported(i, __func__);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance i) { return not_supported(i, __func__); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance i) { return not_supported(i, __func__); }

#define ADCS_NO_CLOCKS(FUNCTION, ...)                                                           \
    fmi3Status FUNCTION(fmi3Instance i, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) { \
        return none_of_type(i, __func__, n, vr);                                                \
    }
ADCS_NO_CLOCKS(fmi3GetIntervalDecimal, fmi3Float64[], fmi3IntervalQualifier[])
ADCS_NO_CLOCKS(fmi3GetIntervalFraction, fmi3UInt64[], fmi3UInt64[], fmi3IntervalQualifier[])
ADCS_NO_CLOCKS(fmi3GetShiftDecimal, fmi3Float64[])
ADCS_NO_CLOCKS(fmi3GetShiftFraction, fmi3UInt64[], fmi3UInt64[])
ADCS_NO_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64[])
ADCS_NO_CLOCKS(fmi3SetIntervalFraction, const fmi3UInt64[], const fmi3UInt64[])
ADCS_NO_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64[])
ADCS_NO_CLOCKS(fmi3SetShiftFraction, const fmi3UInt64[], const fmi3UInt64[])
#undef ADCS_NO_CLOCKS

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi3Status fmi3EnterEventMode(fmi3Instance i) {
    return call(i, mode_continuous | mode_event, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.enter_event_mode(); });
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance i) {
    return call(i, mode_initialization | mode_event, __func__, [](Instance&) { return Status::ok; });
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance i, fmi3Boolean* needs_update, fmi3Boolean* terminate,
                                    fmi3Boolean* nominals_changed, fmi3Boolean* values_changed,
                                    fmi3Boolean* next_event_defined, fmi3Float64* next_event) {
    return call(i, mode_event, Interface::model_exchange, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, needs_update, terminate, nominals_changed, values_changed, next_event_defined,
                   next_event)) {
            return Status::error;
        }
        Discrete discrete;
        const Status status = instance.update_discrete_states(discrete);
        *needs_update = *terminate = *nominals_changed = fmi3False;
        *values_changed = discrete.states_changed;
        *next_event_defined = discrete.next_event_defined;
        *next_event = discrete.next_event;
        return status;
    });
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance i) {
    return call(i, mode_event, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.enter_continuous_time(); });
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance i, fmi3Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi3Boolean* enter_event_mode, fmi3Boolean* terminate) {
    return call(i, mode_continuous, Interface::model_exchange, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, enter_event_mode, terminate)) return Status::error;
        *enter_event_mode = *terminate = fmi3False;
        return Status::ok;
    });
}
fmi3Status fmi3SetTime(fmi3Instance i, fmi3Float64 time) {
    return call(i, mode_event | mode_continuous, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.set_time(time); });
}
fmi3Status fmi3SetContinuousStates(fmi3Instance i, const fmi3Float64 x[], size_t n) {
    return call(i, mode_event | mode_continuous, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.set_states(x, n); });
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance i, fmi3Float64 derivatives[], size_t n) {
    return call(i, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_derivatives(derivatives, n); });
}
fmi3Status fmi3GetEventIndicators(fmi3Instance i, fmi3Float64 indicators[], size_t n) {
    return call(i, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_event_indicators(indicators, n); });
}
fmi3Status fmi3GetContinuousStates(fmi3Instance i, fmi3Float64 x[], size_t n) {
    return call(i, mode_readable, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_states(x, n); });
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance i, fmi3Float64 nominals[], size_t n) {
    return call(i, mode_any, Interface::model_exchange, __func__,
                [&](Instance& instance) { return instance.get_nominals(nominals, n); });
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance i, size_t* n) {
    return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, n)) return Status::error;
        *n = instance.event_indicators();
        return Status::ok;
    });
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance i, size_t* n) {
    return call(i, mode_any, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, n)) return Status::error;
        *n = instance.states();
        return Status::ok;
    });
}

// ------------------------------------------------------------------------------------------------- Co-Simulation

fmi3Status fmi3EnterStepMode(fmi3Instance i) { return not_supported(i, __func__); }
fmi3Status fmi3GetOutputDerivatives(fmi3Instance i, const fmi3ValueReference[], size_t, const fmi3Int32[],
                                    fmi3Float64[], size_t) {
    return not_supported(i, __func__);
}
fmi3Status fmi3DoStep(fmi3Instance i, fmi3Float64 time, fmi3Float64 step,
                      fmi3Boolean /*noSetFMUStatePriorToCurrentPoint*/, fmi3Boolean* event_needed,
                      fmi3Boolean* terminate, fmi3Boolean* early_return, fmi3Float64* last_successful_time) {
    return call(i, mode_step, Interface::co_simulation, __func__, [&](Instance& instance, const char* function) {
        if (!given(instance, function, event_needed, terminate, early_return, last_successful_time))
            return Status::error;
        const Status status = instance.do_step(time, step);
        *event_needed = *terminate = *early_return = fmi3False;
        *last_successful_time = instance.time();
        return status;
    });
}
fmi3Status fmi3ActivateModelPartition(fmi3Instance i, fmi3ValueReference, fmi3Float64) {
    return not_supported(i, __func__);
}

}  // extern "C"
