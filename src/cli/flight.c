#include "cli/flight.h"

#include "core/parallel.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>

enum state {
    FREE,
    BUSY,      // a step runs
    HAS_READ,  // waits to be computed
    COMPUTED,  // waits to be written
    DONE,      // written, or failed; waits to be ended
};

struct slot {
    enum state state;
    gp_status st;
};

/* A flight, under its lock but for the atomic f->head. */
struct scheduler {
    const struct gp_flight_params *p;
    const struct gp_flight_work *work;
    struct gp_flight *f;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    struct slot slot[GP_FLIGHT_MOST]; // unit u has slot u % slots
    int head;          // ended next
    int next_compute;
    int next_read;
    int limit;         // units from here on get no further steps
    gp_status result;  // of work->end() that ended the flight
};

static struct slot *slot_of(struct scheduler *s, int unit)
{
    return &s->slot[unit % s->p->slots];
}

// -- scheduling, under the lock ----------------------------------------------

/* Chooses the next step of this thread; false when there is none. Writing
 * comes before reading: it frees what the unit holds. */
static bool pick_step(struct scheduler *s, bool first_thread, int *unit,
                      enum gp_phase *phase)
{
    // pass units that failed
    while (first_thread &&
           (s->next_compute < s->head ||
            (s->next_compute < s->next_read &&
             slot_of(s, s->next_compute)->state == DONE)))
        s->next_compute++;
    if (first_thread && s->next_compute < s->next_read &&
        s->next_compute < s->limit &&
        slot_of(s, s->next_compute)->state == HAS_READ) {
        *phase = GP_PHASE_COMPUTE;
        *unit = s->next_compute++;
        return true;
    }
    const int end = s->p->ordered ? s->head + 1 : s->next_compute;
    for (int u = s->head; u < end && u < s->next_compute; u++) {
        if (u < s->limit && slot_of(s, u)->state == COMPUTED) {
            *phase = GP_PHASE_WRITE;
            *unit = u;
            return true;
        }
    }
    const int in_flight = s->next_read - s->head;
    if (s->next_read >= s->p->units || s->next_read >= s->limit ||
        in_flight >= s->p->slots ||
        (in_flight > 0 && !s->work->has_room(s->work->user, in_flight)))
        return false;
    *phase = GP_PHASE_READ;
    *unit = s->next_read++;
    return true;
}

static bool is_over(const struct scheduler *s)
{
    return s->result || s->head >= s->p->units;
}

// -- threads -----------------------------------------------------------------

/* Runs steps until all units are ended. */
static void run_steps(struct scheduler *s, bool first_thread)
{
    static const enum state next[] = {
        [GP_PHASE_READ] = HAS_READ, [GP_PHASE_COMPUTE] = COMPUTED,
        [GP_PHASE_WRITE] = DONE,
    };
    int unit;
    enum gp_phase phase;
    pthread_mutex_lock(&s->lock);
    while (!is_over(s)) {
        if (!pick_step(s, first_thread, &unit, &phase)) {
            glarepp_leave(s->p->gp); // another may work while this one waits
            pthread_cond_wait(&s->changed, &s->lock);
            pthread_mutex_unlock(&s->lock);
            glarepp_enter(s->p->gp);
            pthread_mutex_lock(&s->lock);
            continue;
        }
        const int at = unit % s->p->slots;
        s->slot[at].state = BUSY;
        pthread_mutex_unlock(&s->lock);
        const gp_status st = s->work->step(s->work->user, at, unit, phase);
        const bool go = !st || s->work->goes_on(s->work->user, at, st);
        pthread_mutex_lock(&s->lock);
        s->slot[at] = (struct slot) {st ? DONE : next[phase], st};
        if (!go && unit < s->limit)
            s->limit = unit;
        // end finished units, in order
        while (!is_over(s) && s->head < s->next_read &&
               slot_of(s, s->head)->state == DONE) {
            struct slot *const done = slot_of(s, s->head);
            s->result = s->work->end(s->work->user, s->head % s->p->slots,
                                     s->head, done->st);
            *done = (struct slot) {FREE, GP_OK};
            if (s->result)
                break;
            s->head++;
            atomic_store(&s->f->head, s->head);
        }
        pthread_cond_broadcast(&s->changed);
    }
    pthread_mutex_unlock(&s->lock);
}

static void *run_thread(void *arg)
{
    struct scheduler *const s = arg;
    glarepp_enter(s->p->gp);
    run_steps(s, false);
    glarepp_leave(s->p->gp);
    return NULL;
}

gp_status gp_flight_run(const struct gp_flight_params *p,
                        const struct gp_flight_work *work, struct gp_flight *f)
{
    pthread_t id[GP_FLIGHT_MOST];
    struct scheduler s = {
        .p = p, .work = work, .f = f, .limit = INT_MAX,
        .lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER,
    };
    const int most = p->slots < p->units ? p->slots : p->units;
    const int threads = most < gp_threads() ? most : gp_threads();
    sigset_t all, before;
    int started = 0;
    atomic_store(&f->head, 0);
    // signals are for the first thread
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (started < threads - 1 &&
           pthread_create(&id[started], NULL, run_thread, &s) == 0)
        started++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    run_steps(&s, true);
    glarepp_leave(p->gp); // the other threads may still run a step
    for (int i = 0; i < started; i++)
        pthread_join(id[i], NULL);
    glarepp_enter(p->gp);
    pthread_cond_destroy(&s.changed);
    pthread_mutex_destroy(&s.lock);
    return s.result;
}

bool gp_flight_has_room(const struct gp_flight_memory *m, int in_flight)
{
    const size_t half = m->limit / 2;
    return m->limit == 0 ||
           (m->largest > 0 && m->shared < half &&
            m->largest < (half - m->shared) / (size_t) (in_flight + 1));
}

int gp_flight_head(const struct gp_flight *f)
{
    return atomic_load(&f->head);
}
