// Coverage of a pixel by a lens-flare element; the formulas are those of
// sun/sun_priv.h.
//
// in   ROUND, POLYGON, STREAK, IMAGE or PLAIN, one of which is defined
//      edges  polygon: texel (k, sides.y) is side k: nx, ny, 1 / m
//      image  IMAGE, PLAIN: texels in a border of one of 0
//             the rest is flare.vert's
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: flare_cpu.c
flat in ivec2 origin;
flat in vec2 base;
flat in vec2 turn;
flat in vec3 radius;
flat in vec3 inner;
flat in vec3 light;
flat in ivec2 sides;

out vec4 flare;

vec3 clamp1(vec3 v)
{
    return clamp(v, vec3(0.0), vec3(1.0));
}

#ifdef ROUND
vec3 cover_of(vec2 p)
{
    float rho = sqrt(p.x * p.x + p.y * p.y);
    float m = max(abs(p.x), abs(p.y));
    float slope = max(rho, 1e-20) / max(m, 1e-20);
    return clamp1(min(radius, vec3(0.5)) + (radius - rho) * slope) -
           clamp1(min(inner, vec3(0.5)) + (inner - rho) * slope);
}
#endif

#ifdef POLYGON
uniform sampler2D edges;

vec3 cover_of(vec2 p)
{
    float rho = sqrt(p.x * p.x + p.y * p.y);
    float near = min(inner.r, min(inner.g, inner.b)) - 1.0;
    float far = max(radius.r, max(radius.g, radius.b)) + 1.0;
    vec3 cover = vec3(rho < far ? 1.0 : 0.0);
    int n = rho >= near && rho < far ? sides.x : 0;
    for (int i = 0; i < n; i++) {
        vec3 side = texelFetch(edges, ivec2(i, sides.y), 0).xyz;
        float d = side.x * p.x + side.y * p.y;
        cover = min(cover, vec3(0.5) + (inner - d) * side.z);
    }
    return max(cover, vec3(0.0));
}
#endif

#ifdef STREAK
vec3 cover_of(vec2 p)
{
    float steep = 1.0 / max(abs(turn.x), abs(turn.y));
    float v = abs(p.x * turn.y + p.y * turn.x);
    vec3 share = vec3(1.0) / radius;
    vec3 fade = max(vec3(1.0) - abs(p.x * turn.x - p.y * turn.y) * share,
                    vec3(0.0));
    vec3 cover = clamp1(vec3(0.5) + (inner - v) * steep) -
                 clamp1(vec3(0.5) - (inner + v) * steep);
    return cover * (fade * fade);
}
#endif

#if defined(IMAGE) || defined(PLAIN)
uniform sampler2D image;

// Texels t, t + 1 weighted by `part`: a GPU's own filter has 8 bits of it.
vec3 sample_of(ivec2 t, vec2 part)
{
    vec3 upper = mix(texelFetch(image, t, 0).rgb,
                     texelFetch(image, t + ivec2(1, 0), 0).rgb, part.x);
    vec3 lower = mix(texelFetch(image, t + ivec2(0, 1), 0).rgb,
                     texelFetch(image, t + ivec2(1, 1), 0).rgb, part.x);
    return mix(upper, lower, part.y);
}
#endif

#ifdef IMAGE
vec3 cover_of(vec2 p)
{
    vec2 scaled = turn * radius.x;
    vec2 at = vec2(p.x * scaled.x - p.y * scaled.y + inner.x - 0.5,
                   p.x * scaled.y + p.y * scaled.x + inner.y - 0.5);
    vec2 low = floor(at);
    ivec2 last = textureSize(image, 0) - 1;
    ivec2 t = ivec2(clamp(low, vec2(-2.0), vec2(last - 1))) + 1;
    ivec2 u = min(t + 1, last);
    t = max(t, 0);
    vec2 part = at - low;
    vec3 upper = mix(texelFetch(image, t, 0).rgb,
                     texelFetch(image, ivec2(u.x, t.y), 0).rgb, part.x);
    vec3 lower = mix(texelFetch(image, ivec2(t.x, u.y), 0).rgb,
                     texelFetch(image, u, 0).rgb, part.x);
    return mix(upper, lower, part.y);
}
#endif

void main()
{
    vec2 at = gl_FragCoord.xy - 0.5 - vec2(origin);
#ifdef PLAIN
    flare = vec4(light * sample_of(ivec2(at) + ivec2(radius.xy), inner.xy),
                 0.0);
#else
    flare = vec4(light * cover_of(base + at), 0.0);
#endif
}
