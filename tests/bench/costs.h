/* Shared by the parts of `costs`. */
#ifndef GP_BENCH_COSTS_H
#define GP_BENCH_COSTS_H

#include "glare/costs.h"

#include <stdbool.h>

typedef void (*costs_body)(void *ctx);

_Noreturn void costs_die(const char *what);
double costs_now(void);                          // ms of this process
double costs_time(costs_body body, void *ctx);   // ms of a quick run
bool costs_wants(const char *name);
void costs_print(const char *name, const char *built_in, const double *value,
                 int n);

/* Prints the values measured for a macro of costs.h. */
#define COSTS_TEXT_(...) #__VA_ARGS__
#define COSTS_TEXT(...) COSTS_TEXT_(__VA_ARGS__)
#define COSTS_PRINT(NAME, ...)                                                \
    costs_print(#NAME, COSTS_TEXT(NAME), (const double[]) {__VA_ARGS__},      \
                (int) (sizeof (const double[]) {__VA_ARGS__} /                \
                       sizeof(double)))

void costs_direct(void);
void costs_fft(void);
void costs_splat(void);

#endif
