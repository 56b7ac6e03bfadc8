/* y = 1, until `from`; then what `mode` says goes wrong */
#define _POSIX_C_SOURCE 199309L
#include "mock.h"

#include <time.h>

enum { FINE, ERROR, NOT_A_NUMBER, STRANGE, DISCARD, GET_ERROR, TERMINATE, INITIAL_ERROR, WARNING, HANG };

static int now(const Mock *m, int what, double t) { return m->v[mode] == what && t >= m->v[from]; }

static int calculate(Mock *m) {
    m->v[y] = now(m, NOT_A_NUMBER, m->time) ? NAN : 1;
    m->v[der_x] = m->v[y];
    if (now(m, INITIAL_ERROR, m->time)) return say(m, 3, "mode 7 is no good\nto start with");
    if (now(m, GET_ERROR, m->time)) return say(m, 3, "nothing to get");
    return 0;
}
static int step(Mock *m, double t, double h) {
    if (now(m, ERROR, t)) return say(m, 3, "the wheel is stuck");
    if (now(m, STRANGE, t)) return 99;
    if (now(m, DISCARD, t)) return 2;
    if (now(m, WARNING, t)) return say(m, 1, "the wheel squeaks");
    while (now(m, HANG, t)) nanosleep(&(struct timespec){0, 10000000}, NULL);
    m->terminate = now(m, TERMINATE, t);
    m->v[x] += h * m->v[y];
    return 0;
}
static int update(Mock *m) {
    m->terminate = now(m, TERMINATE, m->time);
    return 0;
}
