/* Functions that fmpy wants to find in a Co-Simulation FMU, and that no test of quirks calls. */

#define UNUSED(NAME) \
    int NAME(void) { return 3; }

UNUSED(fmi2Reset) UNUSED(fmi2GetDirectionalDerivative) UNUSED(fmi2SetRealInputDerivatives)
UNUSED(fmi2GetRealOutputDerivatives) UNUSED(fmi2CancelStep) UNUSED(fmi2GetIntegerStatus) UNUSED(fmi2GetStringStatus)
UNUSED(fmi3InstantiateModelExchange) UNUSED(fmi3InstantiateScheduledExecution) UNUSED(fmi3Reset)
UNUSED(fmi3GetNumberOfVariableDependencies) UNUSED(fmi3GetVariableDependencies) UNUSED(fmi3GetDirectionalDerivative)
UNUSED(fmi3GetAdjointDerivative) UNUSED(fmi3SetShiftDecimal) UNUSED(fmi3SetShiftFraction)
UNUSED(fmi3EvaluateDiscreteStates) UNUSED(fmi3GetOutputDerivatives)
UNUSED(fmi3ActivateModelPartition) UNUSED(fmi3CompletedIntegratorStep) UNUSED(fmi3EnterContinuousTimeMode)
UNUSED(fmi3GetContinuousStateDerivatives) UNUSED(fmi3GetContinuousStates) UNUSED(fmi3GetEventIndicators)
UNUSED(fmi3GetNominalsOfContinuousStates) UNUSED(fmi3GetNumberOfContinuousStates)
UNUSED(fmi3GetNumberOfEventIndicators) UNUSED(fmi3SetContinuousStates) UNUSED(fmi3SetTime)
