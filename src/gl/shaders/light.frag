// SPDX-License-Identifier: Apache-2.0
// The pass of one light: adds its light to surfaces of the picture that see it.
//
// in   place    of the surface, from the light, in axes of the world
//      normal   of the surface, any length, on either side
//      eye      of the picture, from the light
//      tint     surface / pi * light, in the picture's units
//      along    direction of a spot or sun; w: 1 / range, 0 without limit
//      cone     x: cosine of a spot's outer angle; y: 1 / (cosine of the inner
//               one - x)
//      shadows  the light's map: reversed depth
//      map      x: texels of a square's side; y: near plane of a spot or point,
//               texel's width of a sun; z: 1 / tan of the half angle, of a
//               sun 1 / the depth that the map holds
//      to_map   from `place` to the map's clip coordinates; not IN_CUBE
// out  light: scene-linear, added
// A surface is in shadow where any of the four texels around it is: the light
// does not leak along the edges of what hides it. Each texel is compared with
// the surface's plane there, or with the surface where its plane is farther:
// no slope, however steep, shadows itself or lets the light pass below what
// hides it. The sets of umbra.h rely on this.
// CPU twin: relight.c
uniform vec4 eye;
uniform vec4 tint;
uniform vec4 along;
uniform vec4 map;
uniform sampler2D shadows;
#ifdef SPOT
uniform vec2 cone;
#endif
#ifndef IN_CUBE
uniform mat4 to_map;
#endif
in vec3 place;
in vec3 normal;
layout(location = 0) out vec4 light;

// True where a texel of the four of a square at `low` around a place in it, in
// [-1, 1], is hidden from the light: a surface there is over `depth` by the
// factor and the summand of `more`. `slope`: the plane's change of depth from
// texel to texel.
bool is_hidden(vec2 at, ivec2 low, float depth, vec2 slope, vec2 more)
{
    int last = int(map.x) - 1;
    vec2 place = (at + 1.0) * 0.5 * map.x - 0.5;
    for (int i = 0; i < 4; i++) {
        ivec2 texel = ivec2(floor(place)) + ivec2(i & 1, i >> 1);
        float plane = depth + max(dot(slope, vec2(texel) - place), 0.0);
        ivec2 from = low + clamp(texel, ivec2(0), ivec2(last));
        if (texelFetch(shadows, from, 0).r * more.x > plane + more.y)
            return true;
    }
    return false;
}

void main()
{
    vec3 n = normalize(normal);
    n = dot(n, eye.xyz - place) < 0.0 ? -n : n;
#ifdef SUN
    vec3 to = -along.xyz;
    float strength = 1.0;
#else
    float d2 = dot(place, place);
    vec3 to = -place * inversesqrt(d2);
    float far = d2 * along.w * along.w;
    float strength = clamp(1.0 - far * far, 0.0, 1.0) / d2;
#endif
#ifdef SPOT
    float edge = clamp((dot(-to, along.xyz) - cone.x) * cone.y, 0.0, 1.0);
    strength *= edge * edge;
#endif
    float cosine = dot(n, to);
    light = vec4(0.0);
    if (cosine <= 0.0 || strength <= 0.0)
        return;
    // the plane's steepest slope, and rounding: in texels' widths
    float least = max(cosine, 0.02);
    float rounding = 0.5 + sqrt(max(1.0 - cosine * cosine, 0.0)) / least / 64.0;
#ifdef IN_CUBE
    vec3 size = abs(place);
    int axis = size.x >= size.y && size.x >= size.z ? 0
               : size.y >= size.z ? 1 : 2;
    float m = size[axis];
    int face = 2 * axis + (place[axis] < 0.0 ? 1 : 0);
    ivec2 low = ivec2(face % 3, face / 3) * int(map.x);
    float inner = (map.x - 2.0) / map.x;
    vec2 at = (axis == 0 ? place.yz : axis == 1 ? place.zx : place.xy) / m
              * inner;
    vec2 tilt = axis == 0 ? n.yz : axis == 1 ? n.zx : n.xy;
    float width = 2.0 / (map.x * inner);
#else
    vec4 q = to_map * vec4(place, 1.0);
    float m = q.w;
    ivec2 low = ivec2(0);
    vec2 at = q.xy / m;
    vec2 tilt = vec2(
        dot(n, normalize(vec3(to_map[0].x, to_map[1].x, to_map[2].x))),
        dot(n, normalize(vec3(to_map[0].y, to_map[1].y, to_map[2].y))));
    float width = 2.0 / (map.x * map.z);
#endif
#ifdef SUN
    float texel = map.y * map.z;
    bool hidden = is_hidden(at, low, q.z, -tilt / least * texel,
                            vec2(1.0, rounding * texel));
#else
    // 1 / m is linear over a square
    bool hidden = is_hidden(at, low, map.y / m,
                            -tilt / (least * length(place)) * (map.y * width),
                            vec2(1.0 - min(0.0005 + rounding * width, 0.1),
                                 0.0));
#endif
    if (!hidden)
        light = vec4(tint.rgb * (cosine * strength), 0.0);
}
