// SPDX-License-Identifier: Apache-2.0
// Adds one target to another of the same size.
//
// in   addend   scene-linear rgb
// out  the same pixel's value, to be added by blending
// CPU twin: none, a plain sum of two planes
uniform sampler2D addend;

out vec4 sum;

void main()
{
    sum = texelFetch(addend, ivec2(gl_FragCoord.xy), 0);
}
