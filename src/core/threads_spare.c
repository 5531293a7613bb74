#include "core/parallel.h"

#include <pthread.h>

enum { MOST = 512 };

/* Stays until all have been tried: the lock is the gate. */
static void *wait_at(void *gate)
{
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

int gp_threads_spare(int most)
{
    pthread_t thread[MOST];
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    int n = 0;
    pthread_mutex_lock(&gate);
    while (n < most && n < MOST &&
           pthread_create(&thread[n], NULL, wait_at, &gate) == 0)
        n++;
    pthread_mutex_unlock(&gate);
    for (int i = 0; i < n; i++)
        pthread_join(thread[i], NULL);
    return n;
}
