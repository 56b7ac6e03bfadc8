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

fmi2Status to_fmi(Status status) { return static_cast<fmi2Status>(status); }

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    Instance* instance = enter(c, mode_any, "fmi2SetDebugLogging");
    return instance == nullptr ? fmi2Error : to_fmi(instance->set_debug_logging(on != fmi2False, n, categories));
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
    Instance* instance = enter(c, mode_instantiated, "fmi2SetupExperiment");
    return instance == nullptr ? fmi2Error : to_fmi(instance->setup(stop_defined != fmi2False, start, stop));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance* instance = enter(c, mode_instantiated, "fmi2EnterInitializationMode");
    return instance == nullptr ? fmi2Error : to_fmi(instance->enter_initialization());
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance* instance = enter(c, mode_initialization, "fmi2ExitInitializationMode");
    return instance == nullptr ? fmi2Error : to_fmi(instance->exit_initialization());
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Instance* instance = enter(c, mode_running, "fmi2Terminate");
    return instance == nullptr ? fmi2Error : to_fmi(instance->terminate());
}

fmi2Status fmi2Reset(fmi2Component c) {
    Instance* instance = enter(c, mode_any, "fmi2Reset");
    return instance == nullptr ? fmi2Error : to_fmi(instance->reset());
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance* instance = enter(c, mode_any, "fmi2GetReal");
    return instance == nullptr ? fmi2Error : to_fmi(instance->get("fmi2GetReal", Addressing::scalars, vr, n, value, n));
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    Instance* instance = enter(c, mode_any, "fmi2GetInteger");
    return instance == nullptr ? fmi2Error
                               : to_fmi(instance->get("fmi2GetInteger", Addressing::scalars, vr, n, value, n));
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean[]) {
    return to_fmi(none_of_type(c, "fmi2GetBoolean", n, vr));
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String[]) {
    return to_fmi(none_of_type(c, "fmi2GetString", n, vr));
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Instance* instance = enter(c, mode_settable, "fmi2SetReal");
    return instance == nullptr ? fmi2Error : to_fmi(instance->set("fmi2SetReal", Addressing::scalars, vr, n, value, n));
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    Instance* instance = enter(c, mode_settable, "fmi2SetInteger");
    return instance == nullptr ? fmi2Error
                               : to_fmi(instance->set("fmi2SetInteger", Addressing::scalars, vr, n, value, n));
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean[]) {
    return to_fmi(none_of_type(c, "fmi2SetBoolean", n, vr));
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String[]) {
    return to_fmi(none_of_type(c, "fmi2SetString", n, vr));
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    Instance* instance = enter(c, mode_any, "fmi2GetFMUstate");
    return instance == nullptr ? fmi2Error : to_fmi(instance->save_new("fmi2GetFMUstate", state));
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Instance* instance = enter(c, mode_any, "fmi2SetFMUstate");
    return instance == nullptr ? fmi2Error : to_fmi(instance->restore("fmi2SetFMUstate", state));
}
fmi2Status fmi2FreeFMUstate(fmi2Component /*c*/, fmi2FMUstate* state) {
    Instance::free_state(state);
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate /*state*/, size_t* size) {
    Instance* instance = enter(c, mode_any, "fmi2SerializedFMUstateSize");
    if (instance == nullptr || !given(instance, "fmi2SerializedFMUstateSize", size)) return fmi2Error;
    *size = instance->state_size();
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    Instance* instance = enter(c, mode_any, "fmi2SerializeFMUstate");
    return instance == nullptr ? fmi2Error : to_fmi(instance->serialize("fmi2SerializeFMUstate", state, bytes, size));
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    Instance* instance = enter(c, mode_any, "fmi2DeSerializeFMUstate");
    return instance == nullptr ? fmi2Error
                               : to_fmi(instance->deserialize("fmi2DeSerializeFMUstate", bytes, size, state));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    Instance* instance = enter(c, mode_readable, "fmi2GetDirectionalDerivative");
    return instance == nullptr
               ? fmi2Error
               : to_fmi(instance->differentiate("fmi2GetDirectionalDerivative", Addressing::scalars, unknowns,
                                                n_unknowns, knowns, n_knowns, seed, n_knowns, sensitivity, n_unknowns));
}

// ------------------------------------------------------------------------------------------------ Model Exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    Instance* instance = enter(c, mode_continuous | mode_event, Interface::model_exchange, "fmi2EnterEventMode");
    return instance == nullptr ? fmi2Error : to_fmi(instance->enter_event_mode());
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    Instance* instance = enter(c, mode_event, Interface::model_exchange, "fmi2NewDiscreteStates");
    if (instance == nullptr || !given(instance, "fmi2NewDiscreteStates", info)) return fmi2Error;
    Discrete discrete;
    const Status status = instance->update_discrete_states(discrete);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = discrete.states_changed ? fmi2True : fmi2False;
    info->nextEventTimeDefined = discrete.next_event_defined ? fmi2True : fmi2False;
    info->nextEventTime = discrete.next_event;
    return to_fmi(status);
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    Instance* instance = enter(c, mode_event, Interface::model_exchange, "fmi2EnterContinuousTimeMode");
    return instance == nullptr ? fmi2Error : to_fmi(instance->enter_continuous_time());
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi2Boolean* enter_event_mode, fmi2Boolean* terminate) {
    constexpr auto function = "fmi2CompletedIntegratorStep";
    Instance* instance = enter(c, mode_continuous, Interface::model_exchange, function);
    if (instance == nullptr || !given(instance, function, enter_event_mode, terminate)) return fmi2Error;
    *enter_event_mode = *terminate = fmi2False;
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    Instance* instance = enter(c, mode_event | mode_continuous, Interface::model_exchange, "fmi2SetTime");
    return instance == nullptr ? fmi2Error : to_fmi(instance->set_time(time));
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    Instance* instance = enter(c, mode_event | mode_continuous, Interface::model_exchange, "fmi2SetContinuousStates");
    return instance == nullptr ? fmi2Error : to_fmi(instance->set_states(x, n));
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    Instance* instance = enter(c, mode_readable, Interface::model_exchange, "fmi2GetDerivatives");
    return instance == nullptr ? fmi2Error : to_fmi(instance->get_derivatives(derivatives, n));
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    Instance* instance = enter(c, mode_readable, Interface::model_exchange, "fmi2GetEventIndicators");
    return instance == nullptr ? fmi2Error : to_fmi(instance->get_event_indicators(indicators, n));
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    Instance* instance = enter(c, mode_readable, Interface::model_exchange, "fmi2GetContinuousStates");
    return instance == nullptr ? fmi2Error : to_fmi(instance->get_states(x, n));
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    Instance* instance = enter(c, mode_any, Interface::model_exchange, "fmi2GetNominalsOfContinuousStates");
    return instance == nullptr ? fmi2Error : to_fmi(instance->get_nominals(nominals, n));
}

// ------------------------------------------------------------------------------------------------- Co-Simulation

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/) {
    Instance* instance = enter(c, mode_step, Interface::co_simulation, "fmi2DoStep");
    return instance == nullptr ? fmi2Error : to_fmi(instance->do_step(time, step));
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]) {
    return to_fmi(not_supported(c, "fmi2SetRealInputDerivatives"));
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                        fmi2Real[]) {
    return to_fmi(not_supported(c, "fmi2GetRealOutputDerivatives"));
}
fmi2Status fmi2CancelStep(fmi2Component c) { return to_fmi(not_supported(c, "fmi2CancelStep")); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind, fmi2Status*) {
    return to_fmi(not_supported(c, "fmi2GetStatus"));
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    if (kind != fmi2LastSuccessfulTime) return to_fmi(not_supported(c, "fmi2GetRealStatus"));
    Instance* instance = enter(c, mode_step | mode_terminated, Interface::co_simulation, "fmi2GetRealStatus");
    if (instance == nullptr || !given(instance, "fmi2GetRealStatus", value)) return fmi2Error;
    *value = instance->time();
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind, fmi2Integer*) {
    return to_fmi(not_supported(c, "fmi2GetIntegerStatus"));
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind, fmi2Boolean*) {
    return to_fmi(not_supported(c, "fmi2GetBooleanStatus"));
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind, fmi2String*) {
    return to_fmi(not_supported(c, "fmi2GetStringStatus"));
}

}  // extern "C"
