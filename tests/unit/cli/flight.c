/* cli/flight, and the log of a frame in cli/progress: units in flight. What
 * they share sees them in order, whatever the threads do. */
#include "unit.h"
#include "cli/flight.h"
#include "cli/progress.h"

#include <time.h>

enum { MOST = 200 };

/* Counts of a flight, for tests. Steps may run on any thread. */
struct seen {
    struct gp_flight flight;
    atomic_int steps[MOST][3];
    atomic_int in_flight, most;    // units between READ and end
    atomic_int at_slot[GP_FLIGHT_MOST];
    atomic_int wrong;
    int computed, ended;           // the last of each, from 1
    int failed[MOST], fails;       // units ended with a failure
    // asked of it
    int slots, fail_every, fail_at;
    enum gp_phase fail_in;
    bool skip, ordered, narrow;
    atomic_int writing;
    struct gp_frame_log logs[GP_FLIGHT_MOST];
    char name[GP_FLIGHT_MOST][16];
    struct gp_log log;
    char text[16384];              // all messages, in their order
};

/* A different pause for each step, the same in every run. */
static void pause_a_little(int unit, enum gp_phase phase)
{
    const unsigned mixed = ((unsigned) unit * 7 + (unsigned) phase * 3 + 1) *
                           2654435761u;
    const struct timespec t = {0, (long) (mixed >> 16 & 0x3f) * 8000};
    nanosleep(&t, NULL);
}

static bool fails(const struct seen *s, int unit, enum gp_phase phase)
{
    return phase == s->fail_in &&
           ((s->fail_every && unit % s->fail_every == 2) || unit == s->fail_at);
}

static void check_step(struct seen *s, int slot, int unit, enum gp_phase phase)
{
    bool wrong = slot != unit % s->slots || slot >= s->slots;
    wrong |= atomic_fetch_add(&s->at_slot[slot], 1) != 0;
    wrong |= atomic_fetch_add(&s->steps[unit][phase], 1) != 0;
    wrong |= phase > 0 && s->steps[unit][phase - 1] != 1;
    if (phase == GP_PHASE_READ) {
        const int now = atomic_fetch_add(&s->in_flight, 1) + 1;
        int most = s->most;
        while (now > most &&
               !atomic_compare_exchange_weak(&s->most, &most, now))
            ;
    }
    if (phase == GP_PHASE_COMPUTE) { // one thread: no atomics
        wrong |= unit + 1 <= s->computed;
        s->computed = unit + 1;
    }
    if (phase == GP_PHASE_WRITE && s->ordered)
        wrong |= atomic_fetch_add(&s->writing, 1) != 0 ||
                 gp_flight_head(&s->flight) != unit;
    if (wrong)
        atomic_fetch_add(&s->wrong, 1);
}

static gp_status step(void *user, int slot, int unit, enum gp_phase phase)
{
    struct seen *const s = user;
    check_step(s, slot, unit, phase);
    if (phase == GP_PHASE_READ) {
        snprintf(s->name[slot], sizeof s->name[slot], "u%d", unit);
        gp_frame_log_open(&s->logs[slot], &s->log, &s->flight, unit,
                      s->name[slot]);
    }
    pause_a_little(unit, phase);
    gp_say(&s->logs[slot].log, GP_LEVEL_WARN, "%d.%d", unit, phase);
    if (phase == GP_PHASE_WRITE && s->ordered)
        atomic_fetch_sub(&s->writing, 1);
    atomic_fetch_sub(&s->at_slot[slot], 1);
    return fails(s, unit, phase)
               ? gp_fail_bare(&s->logs[slot].log, GP_ERR_DATA, "bad %d", unit)
               : GP_OK;
}

static bool goes_on(void *user, int slot, gp_status st)
{
    (void) slot;
    return ((struct seen *) user)->skip && st == GP_ERR_DATA;
}

static bool has_room(void *user, int in_flight)
{
    return !((struct seen *) user)->narrow || in_flight < 2;
}

static gp_status end(void *user, int slot, int unit, gp_status st)
{
    struct seen *const s = user;
    if (unit != s->ended || slot != unit % s->slots)
        atomic_fetch_add(&s->wrong, 1);
    s->ended = unit + 1;
    atomic_fetch_sub(&s->in_flight, 1);
    if (st)
        s->failed[s->fails++] = unit;
    gp_frame_log_flush(&s->logs[slot]);
    gp_frame_log_close(&s->logs[slot]);
    return st && !s->skip ? st : GP_OK;
}

static void note(void *user, const struct gp_line *line)
{
    struct seen *const s = user;
    const size_t at = strlen(s->text);
    snprintf(s->text + at, sizeof s->text - at, "%s ", line->text);
}

static struct seen seen;

static const struct row {
    int units, slots, threads;
} rows[] = {
    {0, 1, 1}, {1, 1, 1}, {1, 8, 8}, {5, 1, 4}, {60, 2, 1}, {60, 3, 2},
    {120, 3, 4}, {120, 7, 3}, {200, 64, 16},
};
enum { ROWS = COUNT(rows) };

/* Flies the units; all are ended when the flight is. */
static void fly(const struct row *r, gp_status want)
{
    struct glarepp_params params = GLAREPP_PARAMS;
    struct gp_flight_params p = {NULL, r->units, r->slots, seen.ordered};
    const struct gp_flight_work work = {&seen, step, goes_on, has_room, end};
    seen.slots = r->slots;
    seen.log = (struct gp_log) {note, &seen, GP_LEVEL_INFO};
    params.threads = r->threads;
    assert_ok((gp_status) glarepp_open(&params, &p.gp));
    glarepp_enter(p.gp);
    assert_int_equal(gp_flight_run(&p, &work, &seen.flight), want);
    glarepp_leave(p.gp);
    glarepp_close(&p.gp);
    for (int i = 0; i < r->slots; i++)
        gp_frame_log_close(&seen.logs[i]);
    assert_int_equal(seen.wrong, 0);
    assert_true(want || seen.ended == r->units);
}

static void clear(void)
{
    memset(&seen, 0, sizeof seen);
    seen.fail_at = -1;
}

/* The words that one thread alone would say. */
static void assert_text(int units, int fail_every)
{
    static char want[16384];
    want[0] = '\0';
    for (int u = 0; u < units; u++) {
        for (int phase = 0; phase < 3; phase++)
            snprintf(want + strlen(want), sizeof want - strlen(want), "%d.%d ",
                     u, phase);
        if (fail_every && u % fail_every == 2) // fails when written
            snprintf(want + strlen(want), sizeof want - strlen(want),
                     "u%d: bad %d ", u, u);
    }
    assert_string_equal(seen.text, want);
}

static void all_in_order(void **state)
{
    for (int k = 0; k < 2 * ROWS; k++) {
        const struct row *const r = &rows[k / 2];
        clear();
        seen.ordered = k % 2;
        fly(r, GP_OK);
        assert_int_equal(seen.fails, 0);
        assert_true(seen.most <= r->slots);
        assert_int_equal(gp_flight_head(&seen.flight), r->units);
        for (int i = 0; i < 3 * r->units; i++)
            assert_int_equal(seen.steps[i / 3][i % 3], 1);
        assert_text(r->units, 0);
    }
}

static void failures_are_skipped(void **state)
{
    for (int k = 0; k < 3 * ROWS; k++) {
        const struct row *const r = &rows[k / 3];
        clear();
        seen.skip = true;
        seen.fail_every = 4;
        seen.fail_in = (enum gp_phase) (k % 3);
        fly(r, GP_OK);
        assert_int_equal(seen.fails, (r->units + 1) / 4);
        for (int i = 0; i < seen.fails; i++)
            assert_int_equal(seen.failed[i], 4 * i + 2);
        if (seen.fail_in == GP_PHASE_WRITE)
            assert_text(r->units, 4);
    }
}

static void first_failure_ends(void **state)
{
    for (int k = 0; k < 3 * ROWS; k++) {
        const struct row *const r = &rows[k / 3];
        const int at = r->units / 2;
        char last[32];
        clear();
        seen.fail_at = at;
        seen.fail_in = (enum gp_phase) (k % 3);
        fly(r, r->units ? GP_ERR_DATA : GP_OK);
        if (!r->units)
            continue;
        assert_int_equal(seen.ended, at + 1);
        for (int u = 0; u < at; u++) // those before are whole
            assert_int_equal(seen.steps[u][GP_PHASE_WRITE], 1);
        for (int u = at + r->slots; u < r->units; u++)
            assert_int_equal(seen.steps[u][GP_PHASE_READ], 0);
        snprintf(last, sizeof last, "u%d: bad %d ", at, at);
        assert_string_equal(seen.text + strlen(seen.text) - strlen(last), last);
    }
}

static void room_bounds_the_flight(void **state)
{
    clear();
    seen.narrow = true;
    fly(&(struct row) {60, 8, 8}, GP_OK);
    assert_true(seen.most <= 2);
    // half of the memory, for all of them
    static const struct {
        struct gp_flight_memory memory;
        int in_flight;
        bool room;
    } row[] = {
        {{0, SIZE_MAX, 0}, 63, true},   {{0, 0, SIZE_MAX}, 63, true},
        {{1200, 0, 0}, 1, false},       {{1200, 299, 0}, 1, true},
        {{1200, 300, 0}, 1, false},     {{1200, 199, 0}, 2, true},
        {{1200, 200, 0}, 2, false},     {{1200, 99, 400}, 1, true},
        {{1200, 100, 400}, 1, false},   {{1200, 1, 600}, 1, false},
        {{1200, 1, SIZE_MAX}, 1, false},
    };
    for (size_t i = 0; i < COUNT(row); i++)
        assert_int_equal(gp_flight_has_room(&row[i].memory, row[i].in_flight),
                         row[i].room);
}

SUITE_OF(flight, NULL, NULL, all_in_order, failures_are_skipped,
         first_failure_ends, room_bounds_the_flight)
