// SPDX-License-Identifier: Apache-2.0
// Texels of sun maps to be added up (Maughan, step 4). Instance = texel of every
// map: a triangle over the whole target, which has a pixel for each light in rows
// as the atlas has maps, stands for a point in each of them.
//
// in   map    x: texels of a map's side; y: points of them that are added up: texels
//             or, where they are fewer, means of four, as evenly as they go
// out  texel  of every map
// CPU twin: mask.c, gp_sun_map_reference()
uniform ivec2 map;

flat out ivec2 texel;

void main()
{
    texel = ivec2(gl_InstanceID % map.y, gl_InstanceID / map.y);
    texel = ((2 * texel + 1) * map.x / map.y - map.x / map.y + 1) / 2;
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,
                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
