/* Functions that fmpy wants to find in a binary, and that no test calls; a mock may define some of them. */

#define UNUSED(NAME) \
    __attribute__((weak)) int NAME(void) { return 3; }

UNUSED(fmi2Reset) UNUSED(fmi2GetString) UNUSED(fmi2SetString) UNUSED(fmi2GetFMUstate) UNUSED(fmi2SetFMUstate)
UNUSED(fmi2FreeFMUstate) UNUSED(fmi2SerializedFMUstateSize) UNUSED(fmi2SerializeFMUstate)
UNUSED(fmi2DeSerializeFMUstate) UNUSED(fmi2GetDirectionalDerivative) UNUSED(fmi2GetEventIndicators)
UNUSED(fmi2GetNominalsOfContinuousStates) UNUSED(fmi2SetRealInputDerivatives) UNUSED(fmi2GetRealOutputDerivatives)
UNUSED(fmi2CancelStep) UNUSED(fmi2GetStatus) UNUSED(fmi2GetRealStatus) UNUSED(fmi2GetIntegerStatus)
UNUSED(fmi2GetBooleanStatus) UNUSED(fmi2GetStringStatus) UNUSED(fmi3InstantiateScheduledExecution)
UNUSED(fmi3Terminate) UNUSED(fmi3Reset) UNUSED(fmi3GetFloat32) UNUSED(fmi3GetInt8) UNUSED(fmi3GetUInt8)
UNUSED(fmi3GetInt16) UNUSED(fmi3GetUInt16) UNUSED(fmi3GetUInt32) UNUSED(fmi3GetInt64) UNUSED(fmi3GetUInt64)
UNUSED(fmi3GetString) UNUSED(fmi3GetBinary) UNUSED(fmi3GetClock) UNUSED(fmi3SetFloat32) UNUSED(fmi3SetInt8)
UNUSED(fmi3SetUInt8) UNUSED(fmi3SetInt16) UNUSED(fmi3SetUInt16) UNUSED(fmi3SetUInt32) UNUSED(fmi3SetInt64)
UNUSED(fmi3SetUInt64) UNUSED(fmi3SetString) UNUSED(fmi3SetBinary) UNUSED(fmi3SetClock)
UNUSED(fmi3GetNumberOfVariableDependencies) UNUSED(fmi3GetVariableDependencies) UNUSED(fmi3GetFMUState)
UNUSED(fmi3SetFMUState) UNUSED(fmi3FreeFMUState) UNUSED(fmi3SerializedFMUStateSize) UNUSED(fmi3SerializeFMUState)
UNUSED(fmi3DeserializeFMUState) UNUSED(fmi3GetDirectionalDerivative) UNUSED(fmi3GetAdjointDerivative)
UNUSED(fmi3EnterConfigurationMode) UNUSED(fmi3ExitConfigurationMode) UNUSED(fmi3GetIntervalDecimal)
UNUSED(fmi3GetIntervalFraction) UNUSED(fmi3GetShiftDecimal) UNUSED(fmi3GetShiftFraction)
UNUSED(fmi3SetIntervalDecimal) UNUSED(fmi3SetIntervalFraction) UNUSED(fmi3SetShiftDecimal)
UNUSED(fmi3SetShiftFraction) UNUSED(fmi3EvaluateDiscreteStates) UNUSED(fmi3GetEventIndicators)
UNUSED(fmi3GetNominalsOfContinuousStates) UNUSED(fmi3GetNumberOfEventIndicators)
UNUSED(fmi3GetNumberOfContinuousStates) UNUSED(fmi3EnterStepMode) UNUSED(fmi3GetOutputDerivatives)
UNUSED(fmi3ActivateModelPartition)
