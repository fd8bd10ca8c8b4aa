// Where the colour of a pixel goes. With MARKS it goes nowhere: from the same triangles a pixel gets
// the mark of what hides at least half of what lies behind, and how far that is along the view.
#ifdef MARKS
#ifdef OWN_MARKS
flat in float v_mark;  // each vertex knows its own
#else
uniform float u_mark;
#define v_mark u_mark
#endif

out vec2 f_mark;  // mark; cm

void show(vec4 colour) {
    if (colour.a < 0.5) discard;
    f_mark = vec2(v_mark, 1.0 / gl_FragCoord.w);
}
#else
out vec4 f_colour;

void show(vec4 colour) {
    f_colour = colour;
}
#endif
