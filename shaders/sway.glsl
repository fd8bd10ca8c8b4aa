// How the water moves what is soft: a slow swell that all feel, and flutter of each tip's own.
vec3 sway_at(vec3 place) {
    float swell = dot(place, vec3(0.011, 0.017, 0.006)) - 1.1 * u_time;
    float flutter = dot(place, vec3(0.31, 0.23, 0.17)) - 2.3 * u_time;
    vec3 way = vec3(sin(swell), 0.6 * sin(0.83 * swell + 1.0), 0.0);
    way += 0.35 * vec3(sin(flutter), cos(0.9 * flutter + 1.0), 0.4 * sin(1.3 * flutter));
    return way;
}
