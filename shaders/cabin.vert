// The vessel around the observer, and the panel before it: corners in cm, right, up, ahead.
uniform mat4 u_clip;

in vec3 in_place;
in vec4 in_look;  // of the vessel: the normal and the brightness; of the panel: texture coordinates

out vec4 v_look;

void main() {
    v_look = in_look;
    gl_Position = u_clip * vec4(in_place, 1.0);
}
