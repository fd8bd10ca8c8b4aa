// As `fishes.frag` shades, without what is too small to see.
#ifdef CAST
void main() {}
#else
#include "fades.glsl"
#include "skin.glsl"
#define BRIGHTEST 32.0
#include "show.glsl"
#include "fish_light.glsl"

uniform sampler2D u_skins;

centroid in vec3 v_sky;
centroid in float v_facing;
flat in vec3 v_sun;
centroid in vec3 v_around;
flat in float v_silver;
centroid in vec3 v_veil;
#ifdef PASSES
centroid in vec3 v_clear;
#else
const vec3 v_clear = vec3(1.0);  // in the light already
#endif
in vec2 v_skin;
flat in vec4 v_tone;
flat in float v_fade;

void main() {
    if (faded(v_fade)) discard;
    vec4 skin = textureLod(u_skins, v_skin, float(COARSEST));
    vec3 colour = toned(skin.rgb, v_tone);
    float silver = silver_of(colour, v_silver);
    vec3 light = (v_sky + v_sun * v_facing) * (1.0 - DARK * silver);
    show(colour * light + mirroring(colour, silver, vec3(1.0)) * v_around, v_veil, v_clear, skin.a);
}
#endif
