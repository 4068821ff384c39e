// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What opaque things send, through which power of the transmittance it is seen, and how far it is.

in vec3 fromEye;
in float ahead;
#ifdef PICTURE
in vec2 place;
uniform sampler2D picture;
#else
in vec3 light;
#endif
layout(location = 0) out vec4 sent;  // linear radiance, power; a power of 0: nothing is here
layout(location = 1) out float howFar;

uniform float power;
uniform int parallel;

void main() {
#ifdef PICTURE
  sent = vec4(texture(picture, place).rgb, power);
#else
  sent = vec4(light, power);
#endif
  howFar = parallel != 0 ? ahead : length(fromEye);  // rays of a parallel camera begin beside the eye
}
