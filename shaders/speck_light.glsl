#include "fish_light.glsl"

uniform sampler2D u_skins;

// The light of a speck, and its opacity: what the skin at a place on the atlas sends of the light on
// it, and what silver mirrors of that around.
vec4 speck_light(vec2 place, vec4 tone, float silvery, vec3 light, vec3 around) {
    vec4 skin = textureLod(u_skins, place, float(COARSEST));
    vec3 colour = toned(skin.rgb, tone);
    float silver = silver_of(colour, silvery);
    return vec4(colour * light * (1.0 - DARK * silver) + mirroring(colour, silver, vec3(1.0)) * around, skin.a);
}
