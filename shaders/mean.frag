// Adds a picture to the sum of an exposure, or divides the sum: one pass of output/exposure.py.
uniform sampler2D u_picture;
uniform float u_share;

out vec4 f_colour;

void main() {
    // A triangle seen edge-on may give less than no light, which would darken all pictures of the sum.
    f_colour = u_share * max(texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0), 0.0);
}
