// SPDX-License-Identifier: Apache-2.0
// Sun map (Maughan, "Texture Masking for Faster Lens Flare", step 3): each
// fragment is a texel of one light's map, the mean of its k x k samples.
// With PIXELS defined: the pixels of a region themselves, for one light.
//
// in   pixels   texel = two pixels, one after the other: place on the light's
//               scale of depth (EMPTY: no surface) and coverage, twice
//      frame    columns and rows of the frame
//      form     x: texels of a map's side; y: 1 a disc, 0 a square
//      from sun_map.vert, the light's:
//      place    centre x and y in pixels of the frame, each as the sum of two
//               floats
//      extent   radius as the sum of two floats; k (0: behind the camera);
//               place at which surfaces are no longer nearer
//      kept     pixels that `pixels` has of it, row after row: the first one
//               in the frame, their width, and the row where they begin
//      beyond   x: share that shows outside the frame; y: its weight
//      corner   its map's first texel
// out  r share shown times g, g weight
// CPU twin: mask.c, gp_sun_map_reference()
uniform sampler2D pixels;

flat in vec4 place;
flat in vec4 extent;
flat in ivec4 kept;
flat in ivec2 corner;

out vec4 map;

const float EMPTY = 3.4e38; // as in mask.c

// Share of a light that a pixel of those kept shows; gp_occluders_show().
float show(ivec2 from)
{
    int at = from.y * kept.z + from.x, wide = textureSize(pixels, 0).x;
    vec4 pair = texelFetch(pixels, ivec2((at >> 1) % wide,
                                         kept.w + (at >> 1) / wide), 0);
    vec2 seen = (at & 1) != 0 ? pair.zw : pair.xy;
    bool hides = seen.x < extent.w || seen.x >= EMPTY;
    return hides ? 1.0 - seen.y : 1.0;
}

#ifdef PIXELS

void main()
{
    map = vec4(show(ivec2(gl_FragCoord.xy)), 1.0, 0.0, 0.0);
}

#else

uniform ivec2 frame;
uniform ivec2 form;

flat in vec2 beyond;

const double NUDGE = 1.0lf / 1048576.0lf; // as in mask.c

// Concentric map (Shirley and Chiu 1997) of [-1, 1]^2, without its axes, to
// the unit disc: the angle is pi / 4 times t, whose sine and cosine are
// Taylor's, exact to 1e-11 over an eighth of a turn.
dvec2 disc_place(dvec2 p)
{
    const double quarter = 0.78539816339744830962lf;
    bool flat_side = abs(p.x) > abs(p.y);
    double a = flat_side ? p.x : p.y;
    double t = quarter * ((flat_side ? p.y : p.x) / a);
    double q = t * t;
    double c = 1.0lf + q * (-1.0lf / 2.0lf + q * (1.0lf / 24.0lf +
        q * (-1.0lf / 720.0lf + q * (1.0lf / 40320.0lf +
        q * (-1.0lf / 3628800.0lf + q * (1.0lf / 479001600.0lf))))));
    double s = 1.0lf + q * (-1.0lf / 6.0lf + q * (1.0lf / 120.0lf +
        q * (-1.0lf / 5040.0lf + q * (1.0lf / 362880.0lf +
        q * (-1.0lf / 39916800.0lf)))));
    dvec2 d = a * dvec2(c, t * s);
    return flat_side ? d : d.yx;
}

void main()
{
    dvec2 centre = dvec2(place.xz) + dvec2(place.yw) + NUDGE;
    double radius = double(extent.x) + double(extent.y);
    int k = int(extent.z);

    // double, so that a sample falls in the same pixel as on the CPU
    ivec2 first = (ivec2(gl_FragCoord.xy) - corner) * k;
    double wide = 2.0lf / double(form.x * max(k, 1));
    vec2 sum = vec2(0.0);
    ivec2 at = ivec2(0);
    // tested at its end: llvmpipe runs code after a break once more, masked
    do {
        dvec2 p = (dvec2(first + at) + 0.5lf) * wide - 1.0lf;
        if (form.y != 0)
            p = disc_place(p);
        dvec2 exact = clamp(centre + radius * p, dvec2(-1.0lf), dvec2(frame));
        ivec2 pixel = ivec2(exact + 1.0lf) - 1; // floor: none under -1
        bool within = all(greaterThanEqual(pixel, ivec2(0))) &&
                      all(lessThan(pixel, frame));
        sum += within ? vec2(show(pixel - kept.xy), 1.0) : beyond;
        at = at.x + 1 < k ? at + ivec2(1, 0) : ivec2(0, at.y + 1);
    } while (at.y < k);
    map = vec4(k > 0 ? sum / float(k * k) : beyond, 0.0, 0.0);
}

#endif
