/* What the parts of `costs` share. */
#ifndef GP_BENCH_COSTS_H
#define GP_BENCH_COSTS_H

#include <stdbool.h>

typedef void (*costs_body)(void *ctx);

_Noreturn void costs_die(const char *what);
double costs_now(void);                          // ms of this process
double costs_time(costs_body body, void *ctx);   // ms of a quick run
bool costs_wants(const char *name);
void costs_put(const char *name, const double *value, int n);
void costs_put_one(const char *name, double value);

void costs_direct(void);
void costs_fft(void);
void costs_splat(void);

#endif
