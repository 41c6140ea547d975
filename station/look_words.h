#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "render/material.h"
#include "render/solid_lens.h"

namespace annulus {

/// A word of LOOK.json and of the command line, and what it stands for.
template <class Value>
struct Word {
  std::string_view word;
  Value value;
};

/// What a half of a frame may be made of.
inline constexpr std::array<Word<Finish>, 4> kMaterialWords = {{{"plastic", Finish::kPlastic},
                                                                {"translucent", Finish::kTranslucent},
                                                                {"metal", Finish::kMetal},
                                                                {"brushed", Finish::kBrushed}}};
inline constexpr std::array<Word<LensCoating>, 3> kCoatingWords = {{{"none", LensCoating::kNone},
                                                                    {"anti_reflective", LensCoating::kAntiReflective},
                                                                    {"mirror", LensCoating::kMirror}}};
inline constexpr std::array<Word<TexturePattern>, 5> kPatternWords = {
    {{"plain", TexturePattern::kPlain},
     {"tortoiseshell", TexturePattern::kTortoiseshell},
     {"horn", TexturePattern::kHorn},
     {"pearl", TexturePattern::kPearl},
     {"carved", TexturePattern::kCarved}}};

template <class Value, std::size_t kCount>
std::string WordOf(const std::array<Word<Value>, kCount>& words, Value value) {
  const auto found = std::find_if(words.begin(), words.end(), [value](const auto& w) { return w.value == value; });
  ENSURE(found != words.end(), "a look holds only what LOOK.json has words for");
  return std::string(found->word);
}

}  // namespace annulus
