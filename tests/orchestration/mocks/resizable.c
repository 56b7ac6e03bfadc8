/* x' = u - k x for k = 1, 2, 3, y = x, events where x passes 1/2; of three elements, whatever the description says first */
#include "mock.h"

static int calculate(Mock *m) {
    for (int i = 0; i < 3; ++i) {
        m->v[der_x + i] = m->v[u + i] - (i + 1) * m->v[x + i];
        m->v[y + i] = m->v[x + i];
        m->v[z + i] = m->v[x + i] - 0.5;
    }
    return 0;
}
static int step(Mock *m, double t, double h) {
    for (int i = 0; i < 3; ++i) m->v[x + i] += h * m->v[der_x + i];
    return 0;
}
static int update(Mock *m) { return 0; }

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 v[], size_t nv) {
    return v[0] == 3 ? fmi3OK : (fmi3Status)say(c, 3, "the size is 3");
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 indicators[], size_t n) {
    if (n != 3) return (fmi3Status)say(c, 3, "there are 3 event indicators");
    const int status = calculate(c);
    memcpy(indicators, M->v + z, sizeof(double[3]));
    return (fmi3Status)status;
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nu,
                                        const fmi3ValueReference knowns[], size_t nk, const fmi3Float64 seed[],
                                        size_t ns, fmi3Float64 out[], size_t n) {
    if (ns != 3 * nk || n != 3 * nu) return (fmi3Status)say(c, 3, "all variables have 3 elements");
    for (size_t j = 0; j < nu; ++j)
        for (int i = 0; i < 3; ++i) {
            double *value = out + 3 * j + i;
            *value = 0.0;
            for (size_t k = 0; k < nk; ++k) {
                const double s = seed[3 * k + i];
                if (unknowns[j] == der_x) *value += knowns[k] == u ? s : -(i + 1) * s;
                else if (knowns[k] == x) *value += s;
            }
        }
    return fmi3OK;
}
