// cvr_decode_brick for the CSGV families. One of the CVR_SERIAL_* sources of symbols is defined
// before this text, and CVR_SERIAL_STOP_BITS (wavelet) or CVR_SERIAL_DELTA (nibble, rANS).
#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/csgv_serial.glsl"
#include "shaders/shared/portable.glsl"

CVR_FUNC void cvr_decode_brick(uvec3 brick, uint lod, Labels labels) {
  uvec3 extent = cvr_extent();
  Global palette = cvr_brick_global(brick);
  SerialBrick serial;
  serial.word_count = cvr_brick_word_count(brick);
  serial.levels = uint(CVR_LEVELS);
  serial.target = uint(CVR_BRICK_SHIFT) - lod;
  serial.palette_size = cvr_brick_palette_size(palette);
  serial.stop_bits = bool(CVR_SERIAL_STOP_BITS);
  serial.delta = bool(CVR_SERIAL_DELTA);
  serial.valid_x = cvr_brick_valid(brick.x, extent.x, uint(CVR_BRICK_SHIFT));
  serial.valid_y = cvr_brick_valid(brick.y, extent.y, uint(CVR_BRICK_SHIFT));
  serial.valid_z = cvr_brick_valid(brick.z, extent.z, uint(CVR_BRICK_SHIFT));
#ifdef CVR_SERIAL_RANS
  cvr_serial_decode(palette, cvr_brick_words(palette), CVR_BUFFER(2), serial, labels);
#else
  cvr_serial_decode(palette, cvr_brick_words(palette), serial, labels);
#endif
}
