#pragma once

#include <array>
#include <string_view>

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

}  // namespace annulus
