// SPDX-License-Identifier: Apache-2.0
/* trace [FIRST SECOND]: ghosts of a lens, or one, by single rays at 26 wavelengths, to check those of the program. It
 * shares nothing with src: a plain loop over surfaces, coats by the matrix of a thin film.
 *
 * Standard input, of numbers: n, index of the stop, blades, turn in degrees, slope of the
 * light; sensor across, down in mm, the light's angle on it in degrees, the axis's place
 * in it in mm from its left upper corner; then for each surface radius (0 flat), thickness,
 * n, V, semi, coat: nm of a layer, 0 bare, -1 - k table k; then the number of tables, and
 * of each its numbers of nm and degrees, these and the shares.
 *
 * Standard output, a line a ghost: first, second, then at each wavelength the light in the
 * frame and all of it, over that of the image on the axis; the wavelengths are the middles
 * of 26 parts of 380 to 780 nm. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64, PARTS = 26, COARSE = 64, FINE = 72, STEPS = 4096 };
#define DEGREE (3.14159265358979323846 / 180.0)

static int n, stop, blades, tables;
static double turn, slope, wide, high, toward, axis_x, axis_y;
static double radius[MOST], thick[MOST], glass[MOST], abbe[MOST], semi[MOST],
    coat[MOST];
static struct table {
    int nms, angles;
    double nm[256], angle[64], share[256 * 64];
} table[16];
static double vertex[MOST + 1], index_of[MOST + 1], lambda;
static float mirror[MOST][2]
                   [STEPS + 2]; // shares by the cosine, forwards and back

static double number(void)
{
    double v;
    if (scanf("%lf", &v) != 1)
        exit(2);
    return v;
}

static double cauchy(double nd, double v, double nm)
{
    const double f = 1 / (486.1327 * 486.1327), c = 1 / (656.2725 * 656.2725);
    const double d = 1 / (587.5618 * 587.5618);
    return v > 0 ? nd + (nd - 1) / v * (1 / (nm * nm) - d) / (f - c) : nd;
}

/* The share that a film of n1 | film | n2 reflects, by its characteristic matrix. */
static double film(double n1, double n2, double sine, double layer)
{
    const double m = fmax(1.38, sqrt(n1 * n2)), s = sine * n1;
    const double c1 = sqrt(1 - sine * sine), c2 = sqrt(1 - s * s / (n2 * n2));
    const double cm = sqrt(1 - s * s / (m * m));
    const double phase = layer > 0 ? 90 * DEGREE * layer / lambda * cm : 0;
    const double x = cos(phase) * cos(phase), y = 1 - x;
    double sum = 0;
    for (int p = 0; p < 2; p++) {
        const double a = p ? n1 / c1 : n1 * c1, b = p ? n2 / c2 : n2 * c2;
        const double e = p ? m / cm : m * cm, q = a * b / e;
        sum += (x * (a - b) * (a - b) + y * (q - e) * (q - e)) /
               (x * (a + b) * (a + b) + y * (q + e) * (q + e));
    }
    return 0.5 * sum;
}

static double of_table(const struct table *t, double degrees)
{
    int i = 0, k = 0;
    while (i + 2 < t->nms && lambda > t->nm[i + 1])
        i++;
    while (k + 2 < t->angles && degrees > t->angle[k + 1])
        k++;
    const double s =
        fmax(0, fmin(1, (lambda - t->nm[i]) / (t->nm[i + 1] - t->nm[i])));
    const double u =
        fmin(1, (degrees - t->angle[k]) / (t->angle[k + 1] - t->angle[k]));
    const double *const at = &t->share[i * t->angles + k];
    const double v = (1 - s) * ((1 - u) * at[0] + u * at[1]) +
                     s * ((1 - u) * at[t->angles] + u * at[t->angles + 1]);
    const double last = t->angle[t->angles - 1];
    return degrees > last ? v + (1 - v) * (degrees - last) / (90 - last) : v;
}

static double reflected(int i, double n1, double n2, double cosine)
{
    const double sine = sqrt(fmax(0, 1 - cosine * cosine));
    if (sine * n1 >= n2)
        return 1;
    if (coat[i] < 0)
        return of_table(&table[(int) (-1 - coat[i])],
                        asin(fmin(1, sine * n1 / fmin(n1, n2))) / DEGREE);
    return film(n1, n2, sine, coat[i]);
}

struct ray {
    double p[3], d[3], light;
    int open[2]; // for the ray, and for its mirror image in y
};

/* Returns 1 where a ray on surface i, or its mirror image, is within its rim, or the
 * blades: only these are not the same in both halves. */
static int is_open(struct ray *r, int i)
{
    if (i != stop || !blades)
        return hypot(r->p[0], r->p[1]) <= semi[i];
    for (int b = 0; b < blades; b++) {
        const double a = (2 * b + 1) * 180.0 / blades - turn - toward;
        const double edge = semi[i] * cos(180.0 / blades * DEGREE);
        const double x = r->p[0] * cos(a * DEGREE),
                     y = r->p[1] * sin(a * DEGREE);
        r->open[0] = r->open[0] && x + y <= edge;
        r->open[1] = r->open[1] && x - y <= edge;
    }
    return r->open[0] || r->open[1];
}

/* Sends a ray to surface i, and through it or back; 0: it is lost. */
static int meet(struct ray *r, int i, int mirrors)
{
    const int back = r->d[2] < 0;
    double normal[3] = {0, 0, -1}, t;
    const double z = vertex[i];
    if (radius[i] == 0) {
        t = (z - r->p[2]) / r->d[2];
    } else {
        const double o[3] = {r->p[0], r->p[1], r->p[2] - z - radius[i]};
        const double b = o[0] * r->d[0] + o[1] * r->d[1] + o[2] * r->d[2];
        const double c =
            o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - radius[i] * radius[i];
        if (b * b < c)
            return 0;
        const double root = sqrt(b * b - c);
        const double t1 = -b - root, t2 = -b + root;
        // the cap at the vertex
        t = fabs(r->p[2] + t1 * r->d[2] - z) < fabs(r->p[2] + t2 * r->d[2] - z)
                ? t1
                : t2;
    }
    for (int k = 0; k < 3; k++)
        r->p[k] += t * r->d[k];
    if (!is_open(r, i))
        return 0;
    if (i == stop)
        return 1;
    if (radius[i] != 0) {
        normal[0] = r->p[0] / radius[i];
        normal[1] = r->p[1] / radius[i];
        normal[2] = (r->p[2] - z) / radius[i] - 1;
    }
    double cosine =
        -(r->d[0] * normal[0] + r->d[1] * normal[1] + r->d[2] * normal[2]);
    if (cosine < 0) {
        for (int k = 0; k < 3; k++)
            normal[k] = -normal[k];
        cosine = -cosine;
    }
    const double n1 = index_of[back ? i + 1 : i],
                 n2 = index_of[back ? i : i + 1];
    const double step = fmin(cosine, 1) * STEPS;
    const float *const m = mirror[i][back] + (int) step;
    const double share = m[0] + (step - (int) step) * (m[1] - m[0]);
    const double ratio = n1 / n2,
                 left = 1 - ratio * ratio * (1 - cosine * cosine);
    if (!mirrors && left <= 0)
        return 0;
    r->light *= mirrors ? share : 1 - share;
    for (int k = 0; k < 3; k++)
        r->d[k] = mirrors ? r->d[k] + 2 * cosine * normal[k]
                          : ratio * r->d[k] +
                                (ratio * cosine - sqrt(left)) * normal[k];
    return 1;
}

/* Traces a ray that enters at x, y by a path; returns its light on the sensor's plane. */
static double trace(int first, int second, double x, double y, double u,
                    double at[2], int open[2])
{
    struct ray r = {
        {x, y, 0}, {u / sqrt(1 + u * u), 0, 1 / sqrt(1 + u * u)}, 1, {1, 1}};
    int i = 0, turns = first < 0 ? 2 : 0;
    while (i < n) {
        const int mirrors =
            (turns == 0 && i == first) || (turns == 1 && i == second);
        if (!meet(&r, i, mirrors))
            return 0;
        turns += mirrors;
        i += turns == 1 ? -1 : 1;
        if (i < 0 || (turns == 1) != (r.d[2] < 0))
            return 0;
    }
    const double t = (vertex[n] - r.p[2]) / r.d[2];
    at[0] = r.p[0] + t * r.d[0];
    at[1] = r.p[1] + t * r.d[1];
    memcpy(open, r.open, sizeof r.open);
    return r.light;
}

static void choose(double nm)
{
    lambda = nm;
    index_of[0] = 1;
    for (int i = 0; i < n; i++) {
        const double n1 = index_of[i], n2 = cauchy(glass[i], abbe[i], nm);
        index_of[i + 1] = n2;
        for (int k = 0; k < STEPS + 2; k++) {
            const double cosine = fmin(1, k / (double) STEPS);
            mirror[i][0][k] =
                n1 == n2 ? 0 : (float) reflected(i, n1, n2, cosine);
            mirror[i][1][k] =
                n1 == n2 ? 0 : (float) reflected(i, n2, n1, cosine);
        }
    }
}

/* The light of a path over a box of its entrance, by `cells` a side in its upper half; the
 * box shrinks to the cells that have light and those beside them. */
static void gather(int first, int second, double u, double box[3], int cells,
                   double *in, double *all)
{
    const double dx = (box[1] - box[0]) / cells, dy = box[2] / cells;
    const double c = cos(toward * DEGREE), e = sin(toward * DEGREE);
    double low = 1e9, top = -1e9, side = 0;
    *in = *all = 0;
    for (int k = 0; k < cells * cells; k++) {
        const double x = box[0] + (k % cells + 0.5) * dx,
                     y = (k / cells + 0.5) * dy;
        double at[2];
        int open[2];
        const double light = trace(first, second, x, y, u, at, open);
        for (int half = 0; half < 2 && light > 0; half++) {
            const double aside = half ? -at[1] : at[1];
            const double px = at[0] * c - aside * e + axis_x;
            const double py = at[0] * e + aside * c + axis_y;
            if (!open[half])
                continue;
            *all += light * dx * dy;
            *in += px >= 0 && px < wide && py >= 0 && py < high
                       ? light * dx * dy
                       : 0;
            low = fmin(low, x - 1.5 * dx);
            top = fmax(top, x + 1.5 * dx);
            side = fmax(side, y + 1.5 * dy);
        }
    }
    if (*all > 0) {
        box[0] = low;
        box[1] = top;
        box[2] = side;
    }
}

int main(int words, char **word)
{
    double image[PARTS], all = 0, in;
    static double light[MOST * MOST][PARTS][2], box[MOST * MOST][3],
        sum[MOST * MOST];
    n = (int) number();
    stop = (int) number();
    blades = (int) number();
    turn = number();
    slope = number();
    wide = number();
    high = number();
    toward = number();
    axis_x = number();
    axis_y = number();
    for (int i = 0; i < n; i++) {
        radius[i] = number();
        thick[i] = number();
        glass[i] = number();
        abbe[i] = number();
        semi[i] = number();
        coat[i] = number();
        vertex[i + 1] = vertex[i] + thick[i];
    }
    tables = (int) number();
    for (int t = 0; t < tables; t++) {
        table[t].nms = (int) number();
        table[t].angles = (int) number();
        for (int i = 0; i < table[t].nms; i++)
            table[t].nm[i] = number();
        for (int i = 0; i < table[t].angles; i++)
            table[t].angle[i] = number();
        for (int i = 0; i < table[t].nms * table[t].angles; i++)
            table[t].share[i] = number();
    }
    // the box of each ghost, and what matters: the others' sum is under .002
    choose(480);
    for (int k = 0; k < n * n; k++) {
        const int first = k / n, second = k % n;
        // slope moves rays from the vertex's plane to the rim
        const double more = 1.2 * semi[0];
        box[k][0] = -more;
        box[k][1] = box[k][2] = more;
        if (second < first && first != stop && second != stop &&
            (words < 3 || (first == atoi(word[1]) && second == atoi(word[2]))))
            gather(first, second, slope, box[k], COARSE, &in, &sum[k]);
        all += sum[k];
    }
    for (int w = 0; w < PARTS; w++) {
        double own[3] = {-semi[0], semi[0], semi[0]};
        choose(380 + 400 * (w + 0.5) / PARTS);
        gather(-1, -1, 0, own, COARSE, &in, &image[w]);
        gather(-1, -1, 0, own, 2 * FINE, &in, &image[w]);
        for (int k = 0; k < n * n; k++) {
            if (!(sum[k] > 1e-5 * all))
                continue;
            memcpy(own, box[k], sizeof own);
            gather(k / n, k % n, slope, own,
                   sum[k] > 1e-3 * all ? FINE : COARSE, &light[k][w][0],
                   &light[k][w][1]);
        }
    }
    for (int k = 0; k < n * n; k++) {
        if (!(sum[k] > 1e-5 * all))
            continue;
        printf("%d %d", k / n, k % n);
        for (int w = 0; w < 2 * PARTS; w++)
            printf(" %.9g", light[k][w / 2][w % 2] / image[w / 2] /
                                sqrt(1 + slope * slope));
        printf("\n");
    }
    return 0;
}
