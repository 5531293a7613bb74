/* Makes the kernel of a run for the frames that need it, and keeps it while one
 * of them is in flight. */
#include "app/options.h"
#include "app/stages.h"

#include "core/clock.h"
#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/tail/tail.h"
#include "io/file.h"
#include "io/plane.h"
#include "io/read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Pixels to which --grow kernel grows frames of models, which have no end: so
 * far only their tails are left. */
enum { MODEL_REACH = 2 * GP_TAIL_CORE + 1 };

// -- the wanted kernel --------------------------------------------------------

void gp_wanted_kernel_free(struct gp_wanted_kernel *k)
{
    for (int i = 0; i < GP_RECIPES; i++) {
        if (i < k->recipes)
            gp_recipe_free(&k->recipe[i]);
        gp_frame_free(&k->image[i]);
    }
    *k = (struct gp_wanted_kernel) {0};
}

/* Refuses options of one image file where there is none. */
static gp_status check_image_options(const struct gp_log *log,
    const struct gp_settings *s, bool files, bool one)
{
    if (s->kernel.size && !files)
        return gp_fail(log, GP_ERR_USAGE, "--kernel-size: no kernel is a plain "
                       "file (found %s); write image:file=PATH,size=DEGREES, "
                       "or leave it out", s->kernel.size);
    if (s->kernel.image.centered && !one)
        return gp_fail(log, GP_ERR_USAGE, "--kernel-center: not for models or "
                       "several kernels (found %g,%g); write "
                       "image:file=PATH,x=COLUMN,y=ROW, or leave it out",
                       s->kernel.image.center[0], s->kernel.image.center[1]);
    if (gp_option_given(s, "kernel-normalize") && !one &&
        s->kernel.image.normalize == GP_NORMALIZE_LUMINANCE)
        return gp_fail(log, GP_ERR_USAGE, "--kernel-normalize: models and "
                       "several kernels share out a pixel's light (found "
                       "luminance); give share=S to each, or leave it out");
    return GP_OK;
}

/* Reads the images that k's recipes name. */
static gp_status read_images(const struct gp_log *log,
    const struct gp_read_params *limits, struct gp_wanted_kernel *k)
{
    for (int i = 0; i < k->recipes; i++) {
        const char *const file = gp_recipe_file(&k->recipe[i]);
        if (!file)
            continue;
        gp_status st = gp_read_frame(log, limits, file, &k->image[i]);
        if (!st && strcmp(gp_model_name(k->recipe[i].model), "image") == 0)
            st = gp_label_read(log, &k->image[i], &k->label[i]);
        if (st)
            return st;
        k->recipe[i].image = &k->image[i];
        k->recipe[i].as_it_is = k->label[i].present;
    }
    return GP_OK;
}

gp_status gp_wanted_kernel_read(const struct gp_log *log,
    const struct gp_settings *s, struct gp_wanted_kernel *out)
{
    const struct gp_read_params limits = gp_read_limits(&s->input.read);
    const char *const *const at = s->kernel.words.at;
    const int n = s->kernel.words.n;
    struct gp_wanted_kernel k = {0};
    bool files = false;
    if (n > GP_RECIPES)
        return gp_fail(log, GP_ERR_USAGE, "--kernel: too many (found %d); give "
                       "up to %d", n, GP_RECIPES);
    for (int i = 0; i < n; i++) {
        const bool file = !gp_recipe_is(at[i]);
        files |= file;
        if (file && !strpbrk(at[i], "./-") && !gp_file_exists(at[i]))
            return gp_fail(log, GP_ERR_IO, "%s: neither a model of kernels nor a "
                           "file; glarepp kernel --list shows the models", at[i]);
    }
    const bool one = n == 1 && files && s->command != GP_COMMAND_KERNEL;
    gp_status st = check_image_options(log, s, files, one);
    if (st)
        return st;
    if (one) {
        st = gp_read_frame(log, &limits, at[0], &out->image[0]);
        return st ? st
                  : gp_label_read(log, &out->image[0], &out->label[0]);
    }
    for (int i = 0; i < n; i++) {
        GP_TRY(gp_recipe_is(at[i])
                   ? gp_recipe_parse(log, at[i], &k.recipe[i])
                   : gp_recipe_of_image(log, at[i], s->kernel.degrees,
                                        s->kernel.percent, &k.recipe[i]));
        k.recipes++;
    }
    GP_TRY(read_images(log, &limits, &k));
    *out = k;
    for (int i = 0; i < n; i++)
        out->recipe[i].image = k.recipe[i].image ? &out->image[i] : NULL;
    return GP_OK;
out:
    gp_wanted_kernel_free(&k);
    return st;
}

struct gp_kernel_params gp_wanted_params(const struct gp_settings *s,
                                         const struct gp_wanted_kernel *k)
{
    struct gp_kernel_params p = s->kernel.image;
    if (k->label[0].present && !gp_option_given(s, "kernel-normalize"))
        p.normalize = GP_NORMALIZE_NONE;
    p.left_out = k->label[0].left_out;
    return p;
}

double gp_wanted_share(const struct gp_wanted_kernel *k)
{
    double all = 0.0, taken = 0.0;
    for (int i = 0; i < gp_max(k->recipes, 1); i++) {
        const double share = k->recipes ? k->recipe[i].value[0] : 1.0;
        all += share;
        taken += share * (k->label[i].present ? k->label[i].share : 1.0);
    }
    return taken / fmax(all, 1.0);
}

// -- made for frames ----------------------------------------------------------

void gp_run_kernel_free(struct gp_run_kernel **k)
{
    if (*k && atomic_fetch_sub(&(*k)->holders, 1) == 1) {
        gp_kernel_free(&(*k)->k);
        gp_free(*k);
    }
    *k = NULL;
}

/* True where the kernel depends on the frame's number. */
static bool moves_in_time(const struct gp_run *r)
{
    bool moves = false;
    for (int i = 0; i < r->kernel.wanted.recipes; i++)
        moves |= gp_recipe_moves(&r->kernel.wanted.recipe[i]);
    return moves;
}

/* True where the recipes of two kernels of the run have the same values. */
static bool has_values(const struct gp_run *r, const struct gp_recipe *a,
                       const struct gp_recipe *b)
{
    bool same = true;
    for (int i = 0; i < r->kernel.wanted.recipes; i++)
        same = same && memcmp(a[i].value, b[i].value, sizeof a->value) == 0;
    return same;
}

/* True where kernel `k` is that of `recipe` for field `b`. */
static bool is_same(const struct gp_run *r, const struct gp_run_kernel *k,
                    const struct gp_recipe *recipe, const struct gp_field *b)
{
    const struct gp_field *const a = &k->field;
    if (!has_values(r, k->recipe, recipe))
        return false;
    const bool coloured =
        r->kernel.wanted.recipes ||
        r->kernel.wanted.image[0].names_chromaticities;
    if (a->aspect != b->aspect ||
        (coloured && memcmp(a->chromaticities, b->chromaticities,
                            8 * sizeof *a->chromaticities) != 0))
        return false;
    if (!r->kernel.wanted.recipes)
        return a->degrees == b->degrees || !(r->s->kernel.degrees > 0.0);
    return a->w == b->w && a->h == b->h && a->degrees == b->degrees &&
           (!moves_in_time(r) || (a->frame == b->frame && a->fps == b->fps));
}

/* Frame pixels for one of the kernel image, in the field's height. */
static double scale_of(const struct gp_run *r, const struct gp_field *field)
{
    const struct gp_frame *const image = &r->kernel.wanted.image[0];
    return r->s->kernel.degrees > 0.0 && field->degrees > 0.0
               ? r->s->kernel.degrees / (field->degrees * gp_frame_h(image))
               : r->s->kernel.percent / 100.0;
}

static size_t bytes_of(const struct gp_kernel *k)
{
    const struct gp_tail *const t = k->tail;
    const size_t nodes =
        t ? (2 * (size_t) t->rx + 1) * (2 * (size_t) t->ry + 1) : 0;
    return 3 * sizeof(float) * ((size_t) k->w * (size_t) k->h + nodes);
}

/* Puts a kernel in the place of made[i], before the others. The older ones may
 * take 128 MiB. */
static void put_first(struct gp_run_kernels *own, int i,
                      struct gp_run_kernel *k)
{
    size_t bytes = 0;
    memmove(&own->made[1], &own->made[0], (size_t) i * sizeof *own->made);
    own->made[0] = k;
    for (i = 1; i < GP_MADE_KERNELS && own->made[i]; i++) {
        bytes += bytes_of(&own->made[i]->k);
        if (bytes > (size_t) 128 << 20)
            gp_run_kernel_free(&own->made[i]);
    }
}

/* Makes the kernel of recipes for a field, unless one that is kept is that;
 * then *made is false.
 *   recipe  those of r->kernel.wanted, with other values */
static gp_status make_kernel(const struct gp_log *log, struct gp_run *r,
    const struct gp_recipe *recipe, const struct gp_field *field, bool *made)
{
    struct gp_run_kernels *const own = &r->kernel;
    struct gp_run_kernel *k;
    *made = false;
    for (int i = 0; i < GP_MADE_KERNELS; i++) {
        if (own->made[i] && is_same(r, own->made[i], recipe, field)) {
            put_first(own, i, own->made[i]);
            return GP_OK;
        }
    }
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *k, &k);
    if (st)
        return st;
    memcpy(k->recipe, recipe, sizeof k->recipe);
    // shapes are kept from kernel to kernel of the same recipes
    if (r->kernel.made[0] && !has_values(r, r->kernel.made[0]->recipe, recipe))
        gp_model_kept_free(&r->kernel.kept);
    struct gp_kernel_params p = gp_wanted_params(r->s, &r->kernel.wanted);
    p.aspect = field->aspect;
    p.scale = scale_of(r, field);
    p.chromaticities = field->chromaticities;
    st = r->kernel.wanted.recipes
             ? gp_model_kernel_next(log, k->recipe, own->wanted.recipes, field,
                                    &own->kept, &k->k)
             : gp_kernel_from_frame(log, &p, &own->wanted.image[0], &k->k);
    if (st) {
        gp_free(k);
        return st;
    }
    const struct gp_frame *const image = &r->kernel.wanted.image[0];
    if (r->kernel.wanted.recipes)
        gp_kernel_glance(&k->k, field->luminance, &k->figures);
    else
        gp_kernel_measure(&k->k, image->names_chromaticities ? field->luminance
                                                             : image->luminance,
                          &k->figures);
    k->field = *field;
    memcpy(k->chromaticities, field->chromaticities, sizeof k->chromaticities);
    k->field.chromaticities = k->chromaticities;
    atomic_init(&k->holders, 1);
    // no other frame will want a kernel of this one's number
    const int last = moves_in_time(r) ? 0 : GP_MADE_KERNELS - 1;
    gp_run_kernel_free(&own->made[last]);
    put_first(own, last, k);
    *made = true;
    return GP_OK;
}

void gp_run_kernels_free(struct gp_run_kernels *k)
{
    for (int i = 0; i < GP_MADE_KERNELS; i++)
        gp_run_kernel_free(&k->made[i]);
    gp_model_kept_free(&k->kept);
    gp_wanted_kernel_free(&k->wanted);
}

/* The field of a frame, and where its angle comes from. */
static struct gp_field find_field(const struct gp_run *r,
                                  struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    double fov = gp_run_fov(r, fs);
    fs->facts.kernel.fov_from = s->kernel.fov > 0.0f ? "option" : "camera";
    if (!(fov > 0.0)) {
        struct gp_lens_stop stop = {.fov = GP_USUAL_FOV};
        fs->facts.kernel.fov_from =
            gp_run_lens_stop(r, fs, &stop) ? "lens" : "default";
        fov = stop.fov;
    }
    struct gp_field field = gp_field_of(&fs->frame, fov);
    field.rotate = (double) s->kernel.image.rotate;
    const double rate = gp_frame_rate(&fs->frame);
    field.fps = rate > 0.0 ? rate : field.fps;
    (void) gp_job_number(fs->job, &field.frame);
    const bool angled = r->kernel.wanted.recipes || s->kernel.degrees > 0.0;
    fs->facts.kernel.deg_per_pixel = angled ? field.degrees : 0.0;
    fs->facts.kernel.fov = fov;
    return field;
}

/* The frame's use of the kernel: of several recipes, with the light that files
 * among them miss; *worst is the one that misses most. */
static struct gp_kernel_use use_of(const struct gp_run *r,
    const struct gp_frame_state *fs, int *worst)
{
    const struct gp_wanted_kernel *const wanted = &r->kernel.wanted;
    const struct gp_frame *const f = &fs->frame;
    const struct gp_field *const field = &r->kernel.made[0]->field;
    struct gp_kernel_use use = {0};
    double shares = 0.0, missed = 0.0, most = 0.0;
    *worst = 0;
    for (int i = 0; i < gp_max(wanted->recipes, 1); i++) {
        const double share =
            wanted->recipes ? wanted->recipe[i].value[0] : 1.0;
        const double scale = wanted->recipes ? 1.0 : scale_of(r, field);
        gp_label_use(&wanted->label[i], scale, &r->kernel.made[0]->k,
                     gp_frame_w(f), gp_frame_h(f), &use);
        missed += share * use.missed;
        *worst = share * use.missed > most ? i : *worst;
        most = fmax(most, share * use.missed);
        shares += share;
    }
    use.missed = missed / fmax(shares, 1.0);
    use.share = gp_wanted_share(wanted);
    use.ends = use.ends && !wanted->recipes;
    if (!wanted->recipes) {
        const struct gp_kernel_params p = gp_wanted_params(r->s, wanted);
        use.as_it_is = use.as_it_is && p.normalize == GP_NORMALIZE_NONE;
        use.centred = p.centered;
        use.resampled = r->kernel.made[0]->k.unturned || field->aspect != 1.0 ||
                        scale_of(r, field) != 1.0;
    }
    use.add = r->s->light.compose.mix == GP_MIX_ADD;
    use.brightest =
        (double) fs->sources.brightest * (double) r->s->light.compose.gain;
    return use;
}

/* Words of --kernel, from the first to before the last, for a message. */
struct kernel_words {
    char text[256];
};

static struct kernel_words words_of(const struct gp_settings *s, int first,
                                    int last)
{
    struct kernel_words w = {"--kernel"};
    for (int i = first; i < gp_min(last, s->kernel.words.n); i++) {
        const size_t used = i > first ? strlen(w.text) : 0;
        snprintf(w.text + used, sizeof w.text - used, "%s%s",
                 i > first ? " and " : "", s->kernel.words.at[i]);
    }
    return w;
}

/* Warns once a run of each fault of the kernel that a frame shows. */
static void warn_of_faults(struct gp_run *r, const struct gp_frame_state *fs,
                           const struct gp_kernel_use *use, int worst)
{
    const struct kernel_words all = words_of(r->s, 0, GP_RECIPES);
    const struct kernel_words one = words_of(r->s, worst, worst + 1);
    for (int i = 0; i < GP_KERNEL_RULES; i++) {
        struct gp_fault fault;
        if (r->kernel.faults_said >> i & 1 ||
            !gp_kernel_fault(&r->kernel.made[0]->figures, use,
                             (enum gp_kernel_rule) i, &fault))
            continue;
        gp_say_at(fs->log, GP_LEVEL_WARN, fault.parameter, "%s: %s",
                  i == GP_RULE_LEFT_OUT ? one.text : all.text, fault.line);
        r->kernel.faults_said |= 1u << i;
    }
}

/* The use of an image that a recipe names, by its keys. */
static struct gp_kernel_use use_of_image(const struct gp_recipe *recipe)
{
    const struct gp_model_key *const keys = gp_model_keys(recipe->model);
    struct gp_kernel_use use = {.as_it_is = recipe->as_it_is};
    for (int i = 0; keys[i].name; i++) {
        if (keys[i].file || recipe->value[i] == keys[i].preset)
            continue;
        use.centred |= strcmp(keys[i].name, "x") == 0 ||
                       strcmp(keys[i].name, "y") == 0;
        use.resampled |= strcmp(keys[i].name, "size") == 0 ||
                         strcmp(keys[i].name, "percent") == 0;
    }
    return use;
}

/* Warns once a run of the faults that the samples of images among several
 * kernels have. */
static gp_status warn_of_images(struct gp_run *r,
                                const struct gp_frame_state *fs)
{
    const unsigned bit = 2u << GP_KERNEL_RULES;
    const bool said = r->kernel.faults_said & bit;
    for (int i = 0; i < r->kernel.wanted.recipes && !said; i++) {
        const struct gp_recipe *const recipe = &r->kernel.wanted.recipe[i];
        const struct gp_kernel_params p = {
            .normalize = GP_NORMALIZE_NONE,
            .left_out = r->kernel.wanted.label[i].left_out,
        };
        const struct gp_kernel_use use = use_of_image(recipe);
        struct gp_kernel_figures f;
        struct gp_kernel k;
        struct gp_fault fault;
        if (strcmp(gp_model_name(recipe->model), "image") != 0)
            continue;
        const gp_status st = gp_kernel_from_frame(fs->log, &p, recipe->image,
                                                  &k);
        if (st)
            return st;
        gp_kernel_measure(&k, recipe->image->luminance, &f);
        gp_kernel_free(&k);
        for (int rule = GP_RULE_SIZE; rule <= GP_RULE_SYMMETRY; rule++) {
            if (gp_kernel_fault(&f, &use, (enum gp_kernel_rule) rule, &fault))
                gp_say_at(fs->log, GP_LEVEL_WARN, fault.parameter, "%s: %s",
                          words_of(r->s, i, i + 1).text, fault.line);
        }
    }
    r->kernel.faults_said |= bit;
    return GP_OK;
}

/* Warns once a run of a file of glarepp kernel that was made for other degrees
 * a pixel than a frame's, where the frame's angle is known. */
static void warn_of_angle(struct gp_run *r, const struct gp_frame_state *fs,
                          const struct gp_field *field)
{
    const unsigned bit = 1u << GP_KERNEL_RULES;
    const struct gp_kernel_label *const l = &r->kernel.wanted.label[0];
    if (r->kernel.wanted.recipes || !l->present ||
        r->kernel.faults_said & bit || strcmp(fs->facts.kernel.fov_from, "default") == 0)
        return;
    const double made = l->fov / l->h;
    const double used = field->degrees * scale_of(r, field);
    if (fabs(used / made - 1.0) <= 0.01)
        return;
    gp_say(fs->log, GP_LEVEL_WARN, "%s: made for %.4g degrees a pixel, used at "
           "%.4g; make it again (glarepp kernel with this --fov and --size), "
           "or set --kernel-size %.4g%%", r->s->kernel.words.at[0], made, used,
           100.0 * made / field->degrees);
    r->kernel.faults_said |= bit;
}

/* The facts about the frame's kernel. */
static void note_kernel(const struct gp_run *r,
                        const struct gp_kernel_use *use,
                        struct gp_kernel_facts *facts)
{
    const struct gp_wanted_kernel *const wanted = &r->kernel.wanted;
    const struct gp_run_kernel *const own = r->kernel.made[0];
    const struct gp_kernel *const k = &own->k;
    facts->recipe = own->recipe;
    facts->recipes = wanted->recipes;
    facts->modelled = wanted->recipes || wanted->label[0].present;
    facts->w = k->w;
    facts->h = k->h;
    facts->grid = k->tail ? k->tail->split.step : 0;
    facts->left_out = fmax(k->left_out, 0.0);
    facts->missed = use->missed;
    memcpy(facts->faint, k->faint, sizeof facts->faint);
    for (int i = 0; i < wanted->recipes; i++)
        facts->pupil[i] = gp_recipe_pupil(&own->recipe[i], &own->field);
}

/* Widens the field so that lights outside of the frame light all of it, up to
 * three frames: in steps, as a light that moves must not remake the kernel for
 * each frame. */
static void reach_lights(const struct gp_run *r,
                         const struct gp_frame_state *fs,
                         struct gp_field *field)
{
    enum { STEP = 128, MOST = 8192 }; // twice that is what all GL drivers draw
    int offset[2], *const size[2] = {&field->w, &field->h};
    gp_suns_offsets(&r->suns, fs->frame.data, offset);
    for (int i = 0; i < 2; i++) {
        const int most = gp_min(3 * *size[i], MOST);
        if (offset[i] >= *size[i])
            *size[i] = gp_max(*size[i], gp_min(most, (offset[i] / STEP + 1) *
                                                         STEP));
    }
}

/* Gives openings the stop of the lens, but for keys that are written. */
static void fit_lens(const struct gp_run *r, const struct gp_lens_stop *stop,
                     struct gp_recipe recipe[GP_RECIPES])
{
    for (int i = 0; i < r->kernel.wanted.recipes; i++) {
        struct gp_recipe *const k = &recipe[i];
        if (strcmp(gp_model_name(k->model), "aperture") != 0)
            continue;
        gp_recipe_preset(k, "blades", stop->blades);
        gp_recipe_preset(k, "roundness", 0.0);
        gp_recipe_preset(k, "rotation", stop->turn);
        gp_recipe_preset(k, "fnumber", stop->f_number);
        gp_recipe_preset(k, "focal", stop->focal);
    }
}

void gp_run_kernel_adapt(const struct gp_run *r, struct gp_frame_state *fs)
{
    bool adapts = false;
    for (int i = 0; i < r->kernel.wanted.recipes; i++)
        adapts |= gp_recipe_adapts(&r->kernel.wanted.recipe[i]);
    if (!adapts)
        return;
    fs->white = GP_USUAL_WHITE;
    double white;
    if (gp_frame_real(&fs->frame, "whiteLuminance", &white) && white > 0.0)
        fs->white = white;
    fs->mean = gp_mean_luminance(&fs->frame, &fs->frame.rgb);
}

gp_status gp_run_kernel_hold(struct gp_run *r, struct gp_frame_state *fs)
{
    gp_status st = GP_OK;
    const double from = gp_now_ms(), cpu = gp_cpu_ms();
    bool made = false;
    if (fs->sources.n > 0 || gp_suns_glare(&r->suns)) {
        struct gp_field field = find_field(r, fs);
        struct gp_recipe recipe[GP_RECIPES];
        struct gp_lens_stop stop;
        memcpy(recipe, r->kernel.wanted.recipe, sizeof recipe);
        if (gp_run_lens_stop(r, fs, &stop))
            fit_lens(r, &stop, recipe);
        for (int i = 0; i < r->kernel.wanted.recipes; i++)
            gp_recipe_adapt(&recipe[i], fs->mean, fs->white);
        reach_lights(r, fs, &field);
        if (r->s->light.edges == GP_SURROUND_MIRROR) {
            const int more = 2 * gp_mirror_reach(gp_frame_w(&fs->frame),
                                                 gp_frame_h(&fs->frame));
            field.w += more;
            field.h += more;
        }
        st = make_kernel(fs->log, r, recipe, &field, &made);
        if (!st)
            st = warn_of_images(r, fs);
        if (!st)
            warn_of_angle(r, fs, &field);
    }
    if (made)
        gp_cost_add(&fs->facts.cost, GP_TIME_KERNEL, gp_now_ms() - from,
                    gp_cpu_ms() - cpu);
    if (!st && r->kernel.made[0]) {
        int worst;
        const struct gp_kernel_use use = use_of(r, fs, &worst);
        warn_of_faults(r, fs, &use, worst);
        note_kernel(r, &use, &fs->facts.kernel);
        fs->kernel = r->kernel.made[0];
        atomic_fetch_add(&fs->kernel->holders, 1);
    }
    return st;
}

const struct gp_kernel *gp_run_kernel_of(const struct gp_frame_state *fs)
{
    static const struct gp_kernel none;
    return fs->kernel ? &fs->kernel->k : &none;
}

gp_status gp_run_kernel_begin(const struct gp_log *log, struct gp_run *r)
{
    static const struct gp_frame square = {.data = {0, 0, 1, 1}};
    gp_status st = gp_wanted_kernel_read(log, r->s, &r->kernel.wanted);
    if (st)
        return st;
    r->kernel.reach = (struct gp_rect) {MODEL_REACH, MODEL_REACH, MODEL_REACH,
                                 MODEL_REACH};
    if (r->kernel.wanted.recipes)
        return GP_OK; // made for the first frame with light
    struct gp_field field = gp_field_of(&square, 0.0);
    field.chromaticities = gp_rec709_chromaticities;
    field.luminance = gp_rec709_luminance;
    bool made;
    st = make_kernel(log, r, r->kernel.wanted.recipe, &field, &made);
    if (st)
        return st;
    const struct gp_kernel *const k = &r->kernel.made[0]->k;
    r->kernel.reach = (struct gp_rect) {k->cx, k->cy, k->w - 1 - k->cx,
                                 k->h - 1 - k->cy};
    return GP_OK;
}

struct gp_rect gp_run_kernel_reach(const struct gp_run *r,
                                   struct gp_frame_state *fs)
{
    const struct gp_field field = find_field(r, fs);
    // in degrees, the first kernel is of the image's own size
    const bool sized = !r->kernel.wanted.recipes && r->s->kernel.degrees > 0.0;
    const double down = sized ? scale_of(r, &field) : 1.0;
    const double across = down / field.aspect;
    const double high = down == 1.0 ? 0.0 : 1.0;  // resampling reaches into
    const double wide = across == 1.0 ? 0.0 : 1.0; // one pixel more
    return (struct gp_rect) {
        gp_max((int) (r->kernel.reach.x0 * across + wide), 0),
        gp_max((int) (r->kernel.reach.y0 * down + high), 0),
        gp_max((int) (r->kernel.reach.x1 * across + wide), 0),
        gp_max((int) (r->kernel.reach.y1 * down + high), 0),
    };
}
