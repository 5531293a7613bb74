// SPDX-License-Identifier: Apache-2.0
// The glare image on an open polygon (Ando et al. 2007, section 3.2), by
// bilinear samples: one texel of the kernel where it lies on whole pixels. The
// four samples are weighted here: a GPU's own filter has weights of 8 bits.
//
// in   kernel    share of a polygon's light: a sample of the three planes a
//                texel, with GREY four samples of a row
//      light     of the polygon, scene-linear rgb
//      corner    target pixel of kernel sample (0, 0)
//      fraction  of a pixel that the kernel lies right of and below that
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: plain_groups.h of the tests
uniform sampler2D kernel;

flat in vec3 light;
flat in ivec2 corner;
flat in vec2 fraction;

out vec4 glare;

// Sample (t.x, t.y); 0 outside.
vec3 share(ivec2 t)
{
#ifdef GREY
    ivec2 at = ivec2(t.x >> 2, t.y);
#else
    ivec2 at = t;
#endif
    if (any(greaterThanEqual(uvec2(at), uvec2(textureSize(kernel, 0)))))
        return vec3(0.0);
    vec4 texel = texelFetch(kernel, at, 0);
#ifdef GREY
    return vec3(texel[t.x & 3]);
#else
    return texel.rgb;
#endif
}

void main()
{
    ivec2 t = ivec2(gl_FragCoord.xy) - corner;
    vec3 sum = share(t);
    if (fraction != vec2(0.0)) {
        vec3 upper = mix(share(t - ivec2(0, 1)), share(t - 1), fraction.x);
        vec3 lower = mix(sum, share(t - ivec2(1, 0)), fraction.x);
        sum = mix(lower, upper, fraction.y);
    }
    glare = vec4(light * sum, 0.0);
}
