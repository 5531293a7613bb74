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
// does not leak along the edges of what hides it.
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

// Nearest of the four texels of a square at `low` around a place in it, in
// [-1, 1].
float nearest(vec2 at, ivec2 low)
{
    int last = int(map.x) - 1;
    ivec2 first = ivec2(floor((at + 1.0) * 0.5 * map.x - 0.5));
    ivec2 a = low + clamp(first, ivec2(0), ivec2(last));
    ivec2 b = low + clamp(first + 1, ivec2(0), ivec2(last));
    return max(max(texelFetch(shadows, a, 0).r,
                   texelFetch(shadows, ivec2(b.x, a.y), 0).r),
               max(texelFetch(shadows, ivec2(a.x, b.y), 0).r,
                   texelFetch(shadows, b, 0).r));
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
    float slope = sqrt(max(1.0 - cosine * cosine, 0.0)) / max(cosine, 0.02);
#ifdef IN_CUBE
    vec3 size = abs(place);
    int axis = size.x >= size.y && size.x >= size.z ? 0
               : size.y >= size.z ? 1 : 2;
    float m = size[axis];
    int face = 2 * axis + (place[axis] < 0.0 ? 1 : 0);
    vec2 xy = axis == 0 ? place.yz : axis == 1 ? place.zx : place.xy;
    float found = nearest(xy / m * ((map.x - 2.0) / map.x),
                          ivec2(face % 3, face / 3) * int(map.x));
#else
    vec4 q = to_map * vec4(place, 1.0);
    float m = q.w;
    float found = nearest(q.xy / m, ivec2(0));
#endif
#ifdef SUN
    bool hidden = found > q.z + (2.0 * slope + 0.5) * map.y * map.z;
#else
    // a texel's width where the surface is, along its slope
    float bias = min(0.0005 + 3.0 * slope / (map.x * map.z), 0.1);
    bool hidden = found * m * (1.0 - bias) > map.y;
#endif
    if (!hidden)
        light = vec4(tint.rgb * (cosine * strength), 0.0);
}
