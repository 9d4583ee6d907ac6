// Each segment of a vessel is a capsule: a rectangle around it is drawn, and every pixel finds the surface exactly.
const LOOK = { hidden: 1, pruned: 2, undecided: 4, picked: 8, marker: 16 };

const VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec4 first;   // x, y, z, mm; radius, mm
layout(location = 1) in vec4 second;
layout(location = 2) in vec2 whose;   // vessel; mm along it to the first end
uniform mat3 turn;
uniform vec3 centre;
uniform vec2 extent;                  // half of the view, mm
uniform float pixel;                  // mm
uniform sampler2D looks;
flat out vec3 a, axis;
flat out float radius, before;
flat out vec4 look;
out vec2 place;
void main() {
  int vessel = int(whose.x + 0.5), wide = textureSize(looks, 0).x;
  look = texelFetch(looks, ivec2(vessel % wide, vessel / wide), 0);
  int state = int(look.a * 255.0 + 0.5);
  if ((state & 1) != 0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  a = (first.xyz - centre) * turn;
  vec3 b = (second.xyz - centre) * turn;
  axis = b - a;
  before = whose.y;
  radius = 0.5 * (first.w + second.w);
  if ((state & 2) != 0) radius *= 0.55;
  radius = max(radius, ((state & 2) != 0 ? 0.7 : 1.0) * pixel);
  if ((state & 16) != 0) radius = max(radius, 3.0 * pixel);
  if ((state & 8) != 0) radius += 2.5 * pixel;
  float flat_length = length(axis.xy);
  vec2 forth = flat_length > 1e-6 * pixel ? axis.xy / flat_length : vec2(1.0, 0.0);
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  float reach = radius + pixel;
  place = (corner.x < 0.5 ? -forth * reach : axis.xy + forth * reach) + vec2(-forth.y, forth.x) * reach * (2.0 * corner.y - 1.0);
  gl_Position = vec4((a.xy + place) / extent, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform float pixel, depth, shift;
flat in vec3 a, axis;
flat in float radius, before;
flat in vec4 look;
in vec2 place;
out vec4 ink;
const vec3 LIGHT = vec3(-0.28, 0.42, 0.86);
const vec3 DARK = vec3(0.1);
void main() {
  int state = int(look.a * 255.0 + 0.5);
  float across = dot(axis.xy, axis.xy), whole = across + axis.z * axis.z, r2 = radius * radius;
  float off = dot(axis.xy, place), from = dot(place, place);
  // The ray comes from the reader: it meets the side, or the ball at an end.
  float height = 0.0, share = axis.z > 0.0 ? 1.0 : 0.0;
  bool side = false;
  if (across > 1e-7 * whole) {
    float b = off * axis.z, under = b * b - across * (whole * from - off * off - r2 * whole);
    if (under < 0.0) discard;
    height = (b + sqrt(under)) / across;
    share = (off + height * axis.z) / whole;
    side = share > 0.0 && share < 1.0;
  }
  if (!side) {
    share = share > 0.5 ? 1.0 : 0.0;
    vec2 rest = place - share * axis.xy;
    float under = r2 - dot(rest, rest);
    if (under < 0.0) discard;
    height = share * axis.z + sqrt(under);
  }
  float along = before + share * sqrt(whole);
  if ((state & 2) != 0 && (state & 8) == 0 && fract(along / (9.0 * pixel)) > 0.58) discard;
  vec3 normal = (vec3(place, height) - share * axis) / radius;
  float light = 0.5 + 0.5 * max(dot(normal, LIGHT), 0.0) / length(LIGHT);
  vec3 colour = look.rgb;
  if ((state & 4) != 0 && fract(along / (12.0 * pixel)) > 0.7) colour = DARK;
  if ((state & 8) != 0) colour = normal.z < 0.75 ? DARK : mix(colour, vec3(1.0, 0.85, 0.1), 0.85);
  colour *= light * mix(0.45, 1.0, smoothstep(0.0, 0.35, normal.z));
  float deep = clamp(0.5 - 0.5 * (a.z + height - shift) / depth, 0.0, 1.0);
  if ((state & 8) == 0) colour = mix(colour, vec3(1.0), 0.3 * smoothstep(0.4, 0.9, deep));
  gl_FragDepth = (state & 8) != 0 ? 0.01 * deep : 0.02 + 0.98 * deep;
  float edge = 0.5 * radius * normal.z * normal.z / pixel;
  ink = vec4(colour, clamp(edge + 0.35, 0.0, 1.0));
}`;
