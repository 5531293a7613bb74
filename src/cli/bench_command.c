/* glarepp bench: the command's side, which reads what a frame's file says. */
#include "cli/commands.h"

#include "cli/output_guard.h"
#include "cli/listener.h"
#include "cli/stages.h"
#include "core/memory.h"

/* The command's one frame, as a job of a run. */
struct user {
    struct gp_run run;
    struct gp_job job;
    struct gp_frame_state state; // its planes
};

static void free_planes(struct user *u)
{
    gp_plane_free(&u->state.depth);
    gp_plane_free(&u->state.mask);
    gp_free(u->state.facts.hidden.depth);
    gp_free(u->state.facts.hidden.mask);
    u->state = (struct gp_frame_state) {0};
}

static gp_status describe(void *user, const struct gp_log *log,
                          const struct gp_frame *f,
                          struct glarepp_frame_params *out)
{
    const struct user *const u = user;
    (void) log;
    *out = gp_frame_params_of(&u->job, f);
    return GP_OK;
}

/* Gives a frame depth and coverage; they stay until it is asked again. */
static gp_status give_planes(void *user, const struct gp_log *log,
                             const struct gp_frame *f,
                             struct glarepp_frame *to)
{
    struct user *const u = user;
    free_planes(u);
    u->state = (struct gp_frame_state) {
        .log = log, .job = &u->job, .file = *f, .frame = to,
    };
    return gp_run_occluders(&u->run, &u->state);
}

gp_status gp_bench_command(const struct gp_log *log, struct glarepp *gp,
                           const struct gp_settings *s)
{
    char *const input = s->input.files.n ? (char *) (uintptr_t)
                                               s->input.files.at[0] : NULL;
    const bool own = gp_option_given(s, "kernel");
    struct user user = {.run = {.s = s}, .job = {.input = input}};
    const struct gp_bench_request req = {
        .params = &s->bench, .gp = gp, .input = input, .default_kernel = !own,
        .kernel_name = own ? s->kernel.words.at[0] : s->light.style,
        .read = &s->input.read, .kernel = &s->kernel.p, .plan = &s->plan,
        .user = &user, .describe = describe, .planes = give_planes,
    };
    gp_status st = gp_output_guard_check(log, s, "input", input);
    if (!st)
        st = gp_bench_run(log, &req);
    free_planes(&user);
    return st;
}
