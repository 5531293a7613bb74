// SPDX-License-Identifier: Apache-2.0
// A rectangle of the sun maps' atlas for each light. Instance = light.
// With PIXELS defined: the region of one light, by itself.
//
// in   lights  row = one light: texels 0 to 3 are place, extent, kept and beyond
//              of sun_map.frag
//      map     texels of a map's side, maps in a row of the atlas
//      size    of the atlas' texture
//   PIXELS:
//      first   pixel of the frame that the target's first one is
//      size    pixels of the region, and of the target
//      light   x: row of `lights`
// out  clip coordinates, and the light's inputs of sun_map.frag
// CPU twin: mask.c, gp_sun_map_reference()
uniform sampler2D lights;
uniform ivec2 size;

flat out vec4 place;
flat out vec4 extent;
flat out ivec4 kept;
flat out vec2 beyond;
flat out ivec2 corner;

void take_light(int i)
{
    place = texelFetch(lights, ivec2(0, i), 0);
    extent = texelFetch(lights, ivec2(1, i), 0);
    kept = ivec4(texelFetch(lights, ivec2(2, i), 0));
    beyond = texelFetch(lights, ivec2(3, i), 0).xy;
}

#ifdef PIXELS

uniform ivec2 first;
uniform ivec2 light;

void main()
{
    take_light(light.x);
    corner = -first;
    gl_Position = clip_of_corner(size * quad_corner(gl_VertexID), size);
}

#else

uniform ivec2 map;

void main()
{
    take_light(gl_InstanceID);
    corner = ivec2(gl_InstanceID % map.y, gl_InstanceID / map.y) * map.x;
    gl_Position = clip_of_corner(corner + map.x * quad_corner(gl_VertexID),
                                 size);
}

#endif
