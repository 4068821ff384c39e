// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_memory.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

TEST(LightMemory, KeepsWhatWasUsedLast) {
  const std::vector<float> values(10, 1.5F);
  LightMemory memory(3 * values.size() * sizeof(float));
  for (const char* key : {"a", "b", "c"}) memory.store(key, values);
  EXPECT_EQ(memory.find("a"), values);
  memory.store("d", values);
  EXPECT_EQ(memory.find("a"), values);
  EXPECT_FALSE(memory.find("b")) << "it was used least lately";
  EXPECT_TRUE(memory.find("c"));
  EXPECT_TRUE(memory.find("d"));
  EXPECT_EQ(memory.bytes(), 120u);
}

TEST(LightMemory, RefusesWhatIsLargerThanAll) {
  LightMemory memory(100);
  memory.store("small", std::vector<float>(10));
  memory.store("large", std::vector<float>(26));
  EXPECT_TRUE(memory.find("small"));
  EXPECT_FALSE(memory.find("large"));
}

}  // namespace
}  // namespace volute
