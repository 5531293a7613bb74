// SPDX-License-Identifier: Apache-2.0
// The pass that sets the picture's depth and its ambient light, or a light's
// map of shadows, which is depth only.
//
// in   colour   of the ambient light that comes back (COLOUR)
//      holes    alpha of the material's texture, in 65535ths (HOLES)
//      cut      x: factor of the texture's alpha; y: opaque from here on
//      wraps    of u and v: 0 repeats, 1 clamps, 2 mirrors
// out  light: colour (COLOUR); else nothing
// CPU twin: the rays of rays.c cut the same holes
#ifdef COLOUR
uniform vec4 colour;
layout(location = 0) out vec4 light;
#endif
#ifdef HOLES
uniform usampler2D holes;
uniform vec2 cut;
uniform ivec2 wraps;
in vec2 uv;

int wrapped(int at, int size, int way)
{
    if (way == 1)
        return clamp(at, 0, size - 1);
    int period = way == 2 ? 2 * size : size;
    at = at - period * int(floor(float(at) / float(period)));
    return at < size ? at : period - 1 - at;
}

float alpha_at(ivec2 at, ivec2 size)
{
    uint code = texelFetch(holes, ivec2(wrapped(at.x, size.x, wraps.x),
                                        wrapped(at.y, size.y, wraps.y)), 0).r;
    return float(code) / 65535.0;
}

// On the base level, between the four texels around it.
float alpha()
{
    ivec2 size = textureSize(holes, 0);
    vec2 at = clamp(uv, vec2(-4096.0), vec2(4096.0)) * vec2(size) - 0.5;
    ivec2 low = ivec2(floor(at));
    vec2 part = at - vec2(low);
    vec2 rows = mix(vec2(alpha_at(low, size), alpha_at(low + ivec2(0, 1), size)),
                    vec2(alpha_at(low + ivec2(1, 0), size),
                         alpha_at(low + ivec2(1, 1), size)), part.x);
    return mix(rows.x, rows.y, part.y);
}
#endif

void main()
{
#ifdef HOLES
    if (cut.x * alpha() < cut.y)
        discard;
#endif
#ifdef COLOUR
    light = colour;
#endif
}
