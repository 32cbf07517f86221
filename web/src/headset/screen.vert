attribute vec3 place;
attribute vec2 spot;
uniform mat4 eye;
uniform vec2 part;
varying vec2 at;
void main() {
  at = vec2(part.x + spot.x * part.y, spot.y);
  gl_Position = eye * vec4(place, 1.0);
}
