// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <typeindex>
#include <utility>
#include <vector>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_programs.hpp"

namespace volute {

/// What stays on the device between pictures, known by what it was made of and by its type.
class GlStore {
 public:
  /// What was made of this source, or what `make` now makes of it: a Result<Made>. Whatever else
  /// was made of the source stays too.
  /// @param holds  whether what was made is still of what the source is now
  template <class Made, class Make, class Holds>
  Result<std::shared_ptr<Made>> get(const std::shared_ptr<const void>& source, Make&& make,
                                    Holds&& holds) {
    Entry& entry = entries_[source.get()];
    if (!entry.source)
      entry.source = source;
    entry.used = true;
    std::shared_ptr<void>& kept = entry.made[typeid(Made)];
    if (!kept || !holds(static_cast<const Made&>(*static_cast<Made*>(kept.get())))) {
      VOLUTE_ASSIGN(auto made, make());
      kept = std::make_shared<Made>(std::move(made));
    }
    return std::static_pointer_cast<Made>(kept);
  }

  template <class Made, class Make>
  Result<std::shared_ptr<Made>> get(const std::shared_ptr<const void>& source, Make&& make) {
    return get<Made>(source, make, [](const Made&) { return true; });
  }

  /// Drops what was made of sources that have not been asked for since the last call.
  void sweep() {
    std::erase_if(entries_, [](const auto& item) { return !item.second.used; });
    for (auto& [source, entry] : entries_) entry.used = false;
  }

 private:
  struct Entry {
    std::shared_ptr<const void> source;  // so that no other one gets its address
    std::map<std::type_index, std::shared_ptr<void>> made;
    bool used = false;
  };

  std::map<const void*, Entry> entries_;
};

/// Names and values, in order.
using GlCounts = std::vector<std::pair<std::string, std::int64_t>>;

/// Buffers, textures and programs that pictures share.
struct GlResources {
  GlDevice device;
  GlPasses passes;
  GlPrograms programs;
  GlStore store;
  std::map<std::string, GlCounts> counts;  ///< what ways of drawing have counted, by their names

  /// GlStore::get(), where making is a pass named "upload". @param media  as GlPart::name()
  template <class Made, class Make, class... Holds>
  Result<std::shared_ptr<Made>> upload(const std::shared_ptr<const void>& source,
                                       const std::string& media, Make&& make, Holds&&... holds) {
    return store.get<Made>(source, [&] { return passes.run("upload", media, make); }, holds...);
  }
};

}  // namespace volute
