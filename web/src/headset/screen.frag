// A picture that is not live is grey, as in the page.
precision mediump float;
uniform sampler2D picture;
uniform float live;
varying vec2 at;
void main() {
  vec3 seen = texture2D(picture, at).rgb;
  vec3 grey = vec3(dot(seen, vec3(0.3, 0.59, 0.11)) * 0.4);
  gl_FragColor = vec4(mix(grey, seen, live), 1.0);
}
