// SPDX-License-Identifier: Apache-2.0
#include "config/yaml_bounds.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

namespace waymark::config {
namespace {

/// Counts what yaml-cpp finds, and throws where it finds too much.
class Bounds final : public YAML::EventHandler {
 public:
  explicit Bounds(const std::string& text) : text_(text) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ == 1) return;
    // yaml-cpp takes a token that fits nowhere for the begin of a document, and does not pass it.
    const std::size_t at = static_cast<std::size_t>(mark.pos) + (text_.starts_with("\xEF\xBB\xBF") ? 3 : 0);
    if (at < text_.size() && text_[at] == ',') {
      throw YAML::ParserException(mark, "a \",\" is not expected here; a text with it needs quotes");
    }
    throw YAML::ParserException(YAML::Mark::null_mark(), "has several documents (---), one is expected");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { add(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override { add(mark); }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void open(const YAML::Mark& mark) {
    add(mark);
    if (++depth_ > kMaxDepth) {
      throw YAML::ParserException(mark, fmt::format("nested too deeply: at most {} levels are expected", kMaxDepth));
    }
  }
  void add(const YAML::Mark& mark) {
    if (++nodes_ > 2 * kMaxNodes)  // keys count here
      throw YAML::ParserException(mark, fmt::format("more than {} keys and values", 2 * kMaxNodes));
  }

  const std::string& text_;
  int documents_ = 0;
  int depth_ = 0;
  std::size_t nodes_ = 0;
};

}  // namespace

void check_yaml_bounds(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Bounds bounds(text);
  while (parser.HandleNextDocument(bounds)) continue;
}

}  // namespace waymark::config
