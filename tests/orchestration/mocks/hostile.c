/* y = 1 + t / 1000, and does what the instance is called, DEED_CALL, in the call of that name: `segfault_doStep`.
 * Where instances have other names, ADCS_DEED of the environment says it, and it is done from the beginning. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

static char what[64], where[64];

static void remember(const char *name);
static void deed(void);

#define NAMED(NAME) remember(NAME)
#define DEED(CALL) (strcmp(where, CALL) == 0 ? deed() : (void)0)
#define AT (getenv("ADCS_DEED") ? -INFINITY : M->v[from])

#include "mock.h"

#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static void remember(const char *name) {
    if (getenv("ADCS_DEED")) name = getenv("ADCS_DEED");
    const char *split = strchr(name, '_');
    if (!split) return;
    snprintf(what, sizeof what, "%.*s", (int)(split - name), name);
    snprintf(where, sizeof where, "%s", split + 1);
}

static int overflow(int n) {
    volatile char page[4096];
    page[0] = (char)n;
    return overflow(n + 1) + page[0];
}

static void flush_denormals(void) {
#if defined(__x86_64__)
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040);
#endif
}

static int hangs_when_unloaded;

__attribute__((destructor)) static void unloaded(void) {
    while (hangs_when_unloaded) sleep(1);
}

static void deed(void) {
#define IS(WHAT) if (strcmp(what, WHAT) == 0)
    IS("segfault") *(volatile int *)8 = 1;
    IS("abort") abort();
    IS("exit") exit(0);
    IS("quit") _exit(0);
    IS("kill") kill(getpid(), SIGKILL);
    IS("trap") raise(SIGFPE);
    IS("overflow") overflow(0);
    IS("alarm") { alarm(1); }
    IS("hang") for (;;) sleep(1);
    IS("spin") for (volatile int i = 0;; ++i) {}
    IS("folder") { if (chdir("/")) abort(); }
    IS("umask") umask(0777);
    IS("limits") { struct rlimit l; getrlimit(RLIMIT_NOFILE, &l); l.rlim_cur = 0; setrlimit(RLIMIT_NOFILE, &l); }
    IS("filesize") { signal(SIGXFSZ, SIG_IGN); setrlimit(RLIMIT_FSIZE, &(struct rlimit){0, 0}); }
    IS("descriptors") for (int i = 3; i < 1024; ++i) close(i);
    IS("print") printf("{\"wheel\": 1}\n");
    IS("rounding") fesetround(FE_UPWARD);
    IS("denormals") flush_denormals();
    IS("locale") setlocale(LC_ALL, "C");
    IS("signals") { signal(SIGINT, SIG_IGN); signal(SIGTERM, SIG_IGN); }
    IS("stop") raise(SIGSTOP);
    IS("unload") hangs_when_unloaded = 1;
    IS("close") for (int i = 0; i < 64; ++i) close(i);
}

static int calculate(Mock *m) {
    m->v[y] = 1 + m->time / 1000;
    m->v[der_x] = 1;
    return 0;
}
static int step(Mock *m, double t, double h) {
    m->v[x] += h;
    return 0;
}
static int update(Mock *m) { return 0; }
