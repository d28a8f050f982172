// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the command says on its standard streams.

#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin::apps {

/// kCannotWrite where the stream cannot take it. A reader that has gone away has had all it wanted: no error.
Expected<void> write_stdout(std::string_view text);

/// One sentence on standard error, after the command's name.
void say(const std::string& sentence);

/// Aligned lines of a name and what there is to say of it.
class Lines {
 public:
  void add(std::string_view name, std::string_view text);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace mapjoin::apps
