/* Runs a component's FMI 2 Co-Simulation on any platform and prints its outputs to the last bit.
   runner LIBRARY TOKEN STEP STEPS [vr=value ...] -- [vr ...] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) ((void*)GetProcAddress(library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    (void)e, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

#define DO(call)                                  \
    if ((call) != fmi2OK) {                       \
        fprintf(stderr, "failed: %s\n", #call);   \
        return 1;                                 \
    }

int main(int argc, char** argv) {
    if (argc < 6) return 2;
    void* library = (void*)OPEN(argv[1]);
    if (library == NULL) {
        fprintf(stderr, "cannot load %s\n", argv[1]);
        return 1;
    }
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2Component c = ((fmi2InstantiateTYPE*)FIND(library, "fmi2Instantiate"))("it", fmi2CoSimulation, argv[2], "",
                                                                               &callbacks, fmi2False, fmi2False);
    if (c == NULL) return 1;
    fmi2SetRealTYPE* set = (fmi2SetRealTYPE*)FIND(library, "fmi2SetReal");
    fmi2GetRealTYPE* get = (fmi2GetRealTYPE*)FIND(library, "fmi2GetReal");
    fmi2DoStepTYPE* step = (fmi2DoStepTYPE*)FIND(library, "fmi2DoStep");
    const double h = atof(argv[3]);
    const int steps = atoi(argv[4]);
    int i = 5;
    for (; i < argc && strcmp(argv[i], "--") != 0; ++i) {
        const fmi2ValueReference vr = (fmi2ValueReference)atoi(argv[i]);
        const fmi2Real value = atof(strchr(argv[i], '=') + 1);
        DO(set(c, &vr, 1, &value));
    }
    DO(((fmi2SetupExperimentTYPE*)FIND(library, "fmi2SetupExperiment"))(c, fmi2False, 0, 0, fmi2False, 0));
    DO(((fmi2EnterInitializationModeTYPE*)FIND(library, "fmi2EnterInitializationMode"))(c));
    DO(((fmi2ExitInitializationModeTYPE*)FIND(library, "fmi2ExitInitializationMode"))(c));
    for (int k = 0; k <= steps; ++k) {
        for (int j = i + 1; j < argc; ++j) {
            const fmi2ValueReference vr = (fmi2ValueReference)atoi(argv[j]);
            fmi2Real value;
            unsigned long long bits;
            DO(get(c, &vr, 1, &value));
            memcpy(&bits, &value, sizeof bits);
            printf("%016llx ", bits);
        }
        printf("\n");
        if (k < steps) DO(step(c, k * h, h, fmi2True));
    }
    return 0;
}
