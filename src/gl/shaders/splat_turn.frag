// The glare image on a turned quad, by bilinear samples of the kernel as it
// was before it was turned.
//
// in   kernel  share of a source's light, in a border of one texel of 0
//      extent  columns and rows of the kernel
//      centre  of the kernel, in its pixels
//      most    cosine and sine of the angle, rounded to 1/1024: their products
//              with whole pixels are exact
//      least   the rest of cosine and sine
//      light   of the source, scene-linear rgb
//      middle  target pixel of the source
//      far     pixels from there that are drawn
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: direct.c with the rotated kernel, gp_rotate()
uniform sampler2D kernel;
uniform ivec2 extent;
uniform ivec2 centre;
uniform vec2 most;
uniform vec2 least;

flat in vec3 light;
flat in ivec2 middle;
flat in int far;

out vec4 glare;

vec2 turned(vec2 by, vec2 d)
{
    return vec2(by.x * d.x - by.y * d.y, by.y * d.x + by.x * d.y);
}

void main()
{
    ivec2 away = ivec2(gl_FragCoord.xy) - middle;
    vec2 d = vec2(away);
    vec2 at = turned(most, d);
    vec2 whole = floor(at);
    vec2 f = at - whole + turned(least, d);
    whole += floor(f);
    f -= floor(f);
    ivec2 t = ivec2(whole) + centre + 1; // texel of the sample's first tap
    if (any(lessThan(t, ivec2(0))) || any(greaterThan(t, extent)) ||
        abs(away.x) > far || abs(away.y) > far)
        discard;
    vec3 upper = mix(texelFetch(kernel, t, 0).rgb,
                     texelFetch(kernel, t + ivec2(1, 0), 0).rgb, f.x);
    vec3 lower = mix(texelFetch(kernel, t + ivec2(0, 1), 0).rgb,
                     texelFetch(kernel, t + ivec2(1, 1), 0).rgb, f.x);
    glare = vec4(light * mix(upper, lower, f.y), 0.0);
}
