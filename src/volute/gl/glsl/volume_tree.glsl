// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Voxels from the hexadeca-tree in memory, read in place: the walk of Ahrenberg et al. 2005, Figure 5, as
// tree4d/tree_node.hpp has it. The buffer holds the arrays of TreeData one after the other, as they are; M_arrays says
// where each begins, in words.

// From the volume's first brick to the one that cells and voxels here count from: floats of cells far away are coarse.
uniform ivec3 M_base;

layout(std430) readonly buffer M_Tree { uint M_words[]; };

struct M_Level {
  int scale;         // bits of the float
  int wide;          // 16 bits a coefficient, else 8
  int coefficients;  // words before the level's
  int escapes;       // words before the places of those that do not fit; their values follow
  int escapeCount;
};

uniform ivec4 M_extents;       // t, z, y, x
uniform int M_frame;
uniform int M_skips;           // 0: every voxel of M_lo..M_hi is walked for, in empty bricks too
uniform int M_entryLevels;     // levels below an entry
uniform ivec4 M_entryCounts;   // t, z, y, x
uniform ivec3 M_brickCounts;   // z, y, x
uniform vec2 M_range;          // values are clamped to it
uniform int M_masks, M_groups, M_childMasks, M_childBases, M_levels, M_entries, M_occupied;  // words before each array

const int M_GROUP = 32;        // nodes a directory entry
const uint M_NONE = 0xFFFFFFFFu;

uint M_half(int array, uint index) { return M_words[array + int(index >> 1)] >> (16u * (index & 1u)) & 0xFFFFu; }

// Sums over the nodes that stand before `node` in its group: coefficients, and nodes with children. All words are
// counted, so that the loop has no end of its own.
uvec2 M_before(uint node) {
  int group = int(node) / M_GROUP;
  uvec2 count = uvec2(M_words[M_groups + 2 * group], M_words[M_groups + 2 * group + 1]);
  int before = int(node) % M_GROUP;
  for (int i = 0; i < M_GROUP / 2; ++i) {
    uint pair = M_words[M_masks + group * (M_GROUP / 2) + i];
    uint counted = bitfieldExtract(0xFFFFFFFFu, 0, clamp(before - 2 * i, 0, 2) * 16);
    count += uvec2(bitCount(pair & counted & 0xFFFEFFFEu), bitCount(pair & counted & 0x00010001u));
  }
  return count;
}

int M_escaped(M_Level level, uint index) {
  int low = 0;
  int high = level.escapeCount - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (M_words[level.escapes + middle] < index) low = middle + 1; else high = middle;
  }
  return int(M_words[level.escapes + level.escapeCount + low]);
}

int M_coefficient(M_Level level, uint index) {
  int q;
  if (level.wide != 0) {
    q = bitfieldExtract(int(M_words[level.coefficients + int(index >> 1)]), int(index & 1u) * 16, 16);
    return q == -32768 ? M_escaped(level, index) : q;
  }
  q = bitfieldExtract(int(M_words[level.coefficients + int(index >> 2)]), int(index & 3u) * 8, 8);
  return q == -128 ? M_escaped(level, index) : q;
}

// What a node adds to its mean in child `o`; it keeps its coefficients channel after channel.
M_VALUE M_detail(M_Level level, uint mask, uint first, uint o) {
  M_VALUE sum = M_VALUE(0.0);
  uint index = first * uint(M_CHANNELS);
#if M_CHANNELS == 3
  uint kept = uint(bitCount(mask & 0xFFFEu));
#endif
  for (uint rest = mask & 0xFFFEu; rest != 0u; rest &= rest - 1u, ++index) {
#if M_CHANNELS == 1
    float q = float(M_coefficient(level, index));
#else
    vec3 q = vec3(M_coefficient(level, index), M_coefficient(level, index + kept), M_coefficient(level, index + 2u * kept));
#endif
    sum += (bitCount(o & uint(findLSB(rest))) & 1) != 0 ? -q : q;
  }
  return sum * intBitsToFloat(level.scale);
}

M_Level M_levelAt(int number) {
  int at = M_levels + 5 * number;
  return M_Level(int(M_words[at]), int(M_words[at + 1]), int(M_words[at + 2]), int(M_words[at + 3]), int(M_words[at + 4]));
}

bool M_isOccupied(ivec3 brick) {  // x, y, z
  if (any(lessThan(brick, ivec3(0))) || any(greaterThanEqual(brick, M_brickCounts.zyx))) return false;
  int bit = ((M_frame * M_brickCounts.x + brick.z) * M_brickCounts.y + brick.y) * M_brickCounts.z + brick.x;
  return (M_words[M_occupied + (bit >> 5)] >> (bit & 31) & 1u) != 0u;
}

M_VALUE M_voxel(ivec3 voxel) {
  voxel += 8 * M_base;
  if (any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, M_extents.wzy))) return M_VALUE(0.0);
  bool occupied = M_isOccupied(voxel >> 3);
  if (!occupied && M_skips != 0) return M_VALUE(0.0);
  ivec4 v = ivec4(M_frame, voxel.zyx);
  ivec4 block = v >> M_entryLevels;
  int entry = M_entries + 4 * (((block.x * M_entryCounts.y + block.y) * M_entryCounts.z + block.z) * M_entryCounts.w + block.w);
  uint node = M_words[entry];
#if M_CHANNELS == 1
  float value = uintBitsToFloat(M_words[entry + 1]);
#else
  vec3 value = vec3(uintBitsToFloat(M_words[entry + 1]), uintBitsToFloat(M_words[entry + 2]), uintBitsToFloat(M_words[entry + 3]));
#endif
  for (int l = M_entryLevels - 1; node != M_NONE && l >= 0; --l) {
    M_Level level = M_levelAt(l);
    uint mask = M_half(M_masks, node);
    ivec4 bits = (v >> l) & 1;
    uint o = uint(bits.x << 3 | bits.y << 2 | bits.z << 1 | bits.w);
    uvec2 before = M_before(node);
    value += M_detail(level, mask, before.x, o);
    node = M_NONE;
    if ((mask & 1u) == 0u) continue;
    uint children = M_half(M_childMasks, before.y);
    if ((children >> o & 1u) != 0u)
      node = M_words[M_childBases + int(before.y)] + uint(bitCount(children & ((1u << o) - 1u)));
  }
  // What a pruned tree leaves in bricks that were empty does not count, whoever walks for it.
  return occupied ? clamp(value, M_range.x, M_range.y) : M_VALUE(0.0);
}

const int M_gap = 0;  // what is empty is a brick

bool M_open(ivec3 brick) {
  if (M_skips == 0) return true;
  brick += M_base;
  bool any = M_isOccupied(brick);
#if M_TRILINEAR
  for (int i = 1; i < 8; ++i) any = any || M_isOccupied(brick - ivec3(i & 1, i >> 1 & 1, i >> 2));
#endif
  return any;
}
