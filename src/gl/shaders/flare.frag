// Image of a lens-flare element.
//
// in   IMAGE: turned and scaled, or PLAIN: at its own pixels
//      image  texels in a border of one of 0
//             the rest is flare.vert's
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: flare_image.c
flat in ivec2 origin;
flat in vec2 base;
flat in vec2 turn;
flat in vec3 radius;
flat in vec3 inner;
flat in vec3 light;

out vec4 flare;

uniform sampler2D image;

#ifdef PLAIN
// Texels t, t + 1 weighted by `part`: a GPU's own filter has 8 bits of it.
vec3 sample_of(ivec2 t, vec2 part)
{
    vec3 upper = mix(texelFetch(image, t, 0).rgb,
                     texelFetch(image, t + ivec2(1, 0), 0).rgb, part.x);
    vec3 lower = mix(texelFetch(image, t + ivec2(0, 1), 0).rgb,
                     texelFetch(image, t + ivec2(1, 1), 0).rgb, part.x);
    return mix(upper, lower, part.y);
}
#else
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
