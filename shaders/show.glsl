// Output of a pixel: its light on the canvas. With PASSES the parts of this light, for compositing: see output/passes.py.
// With OBJECT_IDS the object id of what hides at least half of what lies behind it, the distance along the view, and the
// slopes of its inverse.
#ifdef OBJECT_IDS
#ifdef OWN_IDS
flat in float v_object_id;  // per vertex
#else
uniform float u_object_id;
#define v_object_id u_object_id
#endif

out vec4 f_object_id;  // object id; cm; change of 1 / cm to the right and up

void show(vec3 light, vec3 veil, vec3 clear, float opacity) {
    vec2 slope = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w));
    if (opacity < 0.5) discard;
    f_object_id = vec4(v_object_id, 1.0 / gl_FragCoord.w, slope);
}
#else
#ifndef BRIGHTEST
#define BRIGHTEST 128.0  // the sun above the surface reaches 70
#endif

// With several samples a pixel, slivers of triangles are lit by numbers far outside those of their
// corners, however they are interpolated: one such pixel would bloom over the picture.
vec3 bounded(vec3 light) {
    return clamp(light, 0.0, BRIGHTEST);
}

#ifdef PASSES
layout(location = 0) out vec4 f_light;
layout(location = 1) out vec4 f_veil;
layout(location = 2) out vec4 f_clear;
layout(location = 3) out vec4 f_cover;

// Each part is blended by the opacity, as the picture is. `cover` is 1 where the opacity tells how
// much of a pixel is covered.
void show_parts(vec3 light, vec3 veil, vec3 clear, float cover, float opacity) {
    f_light = vec4(bounded(light), opacity);
    f_veil = vec4(bounded(veil), opacity);
    f_clear = vec4(bounded(clear), opacity);
    f_cover = vec4(cover, 0.0, 0.0, opacity);
}

void show(vec3 light, vec3 veil, vec3 clear, float opacity) {
    show_parts(light, veil, clear, 1.0, opacity);
}
#else
#ifdef INTEGERS
const float UNIT = 1.0 / 8.0;  // as u_unit; a software renderer reads a uniform for each pixel
#else
const float UNIT = 1.0;
#endif

out vec4 f_colour;

// `light` of a thing is what arrives of it; `veil` is the light that the water adds on the way, and
// `clear` the share of each colour that the water lets through.
void show(vec3 light, vec3 veil, vec3 clear, float opacity) {
#ifdef INTEGERS  // which are bounded, and of one sample
    f_colour = vec4(UNIT * (light + veil), opacity);
#else
    f_colour = vec4(bounded(light) + bounded(veil), opacity);
#endif
}
#endif
#endif
