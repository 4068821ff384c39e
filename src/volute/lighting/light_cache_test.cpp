// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_cache.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <numeric>

#include "volute/base/program.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

class Folder : public ::testing::Test {
 protected:
  std::vector<fs::path> files() const {
    std::vector<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
    return paths;
  }

  const ScratchFolder scratch;
  const fs::path folder = scratch.path();
};

using LightCacheTest = Folder;

const std::string kKey(32, 'a');

std::vector<float> someValues(std::size_t count = 100) {
  std::vector<float> values(count);
  std::iota(values.begin(), values.end(), 0.5F);
  return values;
}

TEST_F(LightCacheTest, KeepsValuesUnderTheirKey) {
  const auto cache = LightCache::open(folder / "deep" / "er", 1 << 20);
  ASSERT_TRUE(cache.has_value());
  EXPECT_FALSE(cache->find(kKey, 100));
  ASSERT_TRUE(cache->store(kKey, someValues()).has_value());
  EXPECT_EQ(cache->find(kKey, 100), someValues());
  EXPECT_FALSE(cache->find(kKey, 99));
  EXPECT_FALSE(cache->find(std::string(32, 'b'), 100));
  EXPECT_EQ(LightCache::open(folder / "deep" / "er", 1 << 20)->find(kKey, 100), someValues());
}

TEST_F(LightCacheTest, DoesNotTrustDamagedFiles) {
  const auto cache = LightCache::open(folder, 1 << 20);
  ASSERT_TRUE(cache->store(kKey, someValues()).has_value());
  const fs::path path = files().at(0);
  const auto size = fs::file_size(path);
  for (std::uintmax_t byte = 0; byte < size; ++byte) {
    const auto flip = [&] {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(static_cast<std::streamoff>(byte));
      const char was = static_cast<char>(file.get());
      file.seekp(static_cast<std::streamoff>(byte));
      file.put(static_cast<char>(was ^ 4));
    };
    flip();
    EXPECT_FALSE(cache->find(kKey, 100)) << byte;
    flip();
  }
  EXPECT_TRUE(cache->find(kKey, 100));
  fs::resize_file(path, size - 1);
  EXPECT_FALSE(cache->find(kKey, 100));
}

TEST_F(LightCacheTest, ForgetsWhatWasUsedLeastLately) {
  constexpr std::size_t kFile = 56 + 400;
  const auto cache = LightCache::open(folder, 3 * kFile);
  const auto used = [&](const std::string& key, int secondsAgo) {
    fs::last_write_time(folder / (key + ".light"),
                        fs::file_time_type::clock::now() - std::chrono::seconds(secondsAgo));
  };
  const std::string keys[] = {std::string(32, '0'), std::string(32, '1'), std::string(32, '2'),
                              std::string(32, '3')};
  std::ofstream(folder / "a stranger's.txt") << "stays";
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(cache->store(keys[i], someValues()).has_value());
    used(keys[i], 100 - i);
  }
  EXPECT_TRUE(cache->find(keys[0], 100));  // used now
  ASSERT_TRUE(cache->store(keys[3], someValues()).has_value());
  EXPECT_TRUE(cache->find(keys[0], 100));
  EXPECT_FALSE(cache->find(keys[1], 100));
  EXPECT_TRUE(cache->find(keys[3], 100));
  EXPECT_EQ(files().size(), 4u);
  ASSERT_TRUE(cache->store(kKey, someValues(1000)).has_value());  // larger than all
  EXPECT_FALSE(cache->find(kKey, 1000));
}

TEST_F(LightCacheTest, LivesWhereTheDesktopSays) {
  setenv("XDG_CACHE_HOME", "/somewhere", 1);
  EXPECT_EQ(LightCache::usualFolder(), "/somewhere/volute/light");
  unsetenv("XDG_CACHE_HOME");
  setenv("HOME", "/home/me", 1);
  EXPECT_EQ(LightCache::usualFolder(), "/home/me/.cache/volute/light");
  EXPECT_FALSE(LightCache::open("/proc/none", 1).has_value());
}

}  // namespace
}  // namespace volute
