// Points of the intensity map (Maughan, step 4): texel (i, j) of the sun maps
// of all lights at once, each light's into the pixel that is its own. The
// target has a pixel for each light, in rows as the atlas has maps, and a
// point is as large as the target: with one light, a point of one pixel. Where
// points cannot be that large, each instance is a tile of the target.
//
// in   map     x: texels of a map's side
//      tiles   x: tiles in a row, y: rows of them; the view is as large
//      width   x: of a tile, pixels
// out  texel   of every light's map; BILINEAR: corner between 2 x 2 of them
// CPU twin: map.c, gp_sun_map_reference()
uniform ivec2 map;
uniform ivec2 tiles;
uniform ivec2 width;

flat out ivec2 texel;

void main()
{
#ifdef BILINEAR
    int side = map.x / 2;
    texel = 2 * ivec2(gl_VertexID % side, gl_VertexID / side) + 1;
#else
    texel = ivec2(gl_VertexID % map.x, gl_VertexID / map.x);
#endif
    ivec2 tile = ivec2(gl_InstanceID % tiles.x, gl_InstanceID / tiles.x);
    gl_Position = vec4(vec2(2 * tile + 1 - tiles) / vec2(tiles), 0.0, 1.0);
    gl_PointSize = float(width.x);
}
