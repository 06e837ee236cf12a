#include "io/xml.h"

#include <cctype>
#include <cstdint>

#include "base/error.h"

namespace vol::io {
namespace {

bool is_space(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

/// Code point as UTF-8.
std::string utf8(std::uint32_t code) {
  const auto byte = [](std::uint32_t b) { return static_cast<char>(static_cast<unsigned char>(b)); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xc0 | code >> 6), byte(0x80 | (code & 0x3f))};
  if (code < 0x10000)
    return {byte(0xe0 | code >> 12), byte(0x80 | (code >> 6 & 0x3f)), byte(0x80 | (code & 0x3f))};
  return {byte(0xf0 | (code >> 18 & 7)), byte(0x80 | (code >> 12 & 0x3f)), byte(0x80 | (code >> 6 & 0x3f)),
          byte(0x80 | (code & 0x3f))};
}

std::string unescaped(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t stop = text[0] == '&' ? text.find(';') : std::string_view::npos;
    if (stop == std::string_view::npos || stop > 10) {
      plain += text[0];
      text.remove_prefix(1);
      continue;
    }
    const std::string entity(text.substr(1, stop - 1));
    text.remove_prefix(stop + 1);
    if (entity == "lt") {
      plain += '<';
    } else if (entity == "gt") {
      plain += '>';
    } else if (entity == "amp") {
      plain += '&';
    } else if (entity == "quot") {
      plain += '"';
    } else if (entity == "apos") {
      plain += '\'';
    } else if (entity.size() > 1 && entity[0] == '#') {
      const bool hex = entity[1] == 'x';
      const unsigned long code = std::strtoul(entity.c_str() + (hex ? 2 : 1), nullptr, hex ? 16 : 10);
      plain += utf8(static_cast<std::uint32_t>(code & 0x1fffff));
    }
  }
  return plain;
}

}  // namespace

void XmlReader::refuse(const char* what) const {
  throw Error(file_ + ": XML at byte " + std::to_string(at_) + ": " + what);
}

void XmlReader::skip_space() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
}

void XmlReader::skip_past(std::string_view mark) {
  const std::size_t found = text_.find(mark, at_);
  if (found == std::string_view::npos) refuse("a comment or declaration has no end");
  at_ = found + mark.size();
}

std::string XmlReader::name() {
  const std::size_t start = at_;
  while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '=' && text_[at_] != '>' &&
         text_[at_] != '/' && text_[at_] != '<') {
    ++at_;
  }
  if (at_ == start) refuse("a name is missing");
  return std::string(text_.substr(start, at_ - start));
}

XmlTag XmlReader::next() {
  XmlTag tag;
  for (;;) {
    at_ = text_.find('<', at_);
    if (at_ == std::string_view::npos) {
      at_ = text_.size();
      return tag;
    }
    if (text_.compare(at_, 4, "<!--") == 0) {
      skip_past("-->");
    } else if (text_.compare(at_, 2, "<?") == 0 || text_.compare(at_, 2, "<!") == 0) {
      skip_past(">");
    } else {
      break;
    }
  }
  ++at_;
  const bool closing = at_ < text_.size() && text_[at_] == '/';
  if (closing) ++at_;
  tag.name = name();
  tag.kind = closing ? XmlTag::Kind::close : XmlTag::Kind::open;
  for (;;) {
    skip_space();
    if (at_ >= text_.size()) refuse("a tag has no end");
    if (text_[at_] == '>') break;
    if (text_[at_] == '/') {
      tag.kind = XmlTag::Kind::empty;
      ++at_;
      continue;
    }
    const std::string attribute = name();
    skip_space();
    if (at_ >= text_.size() || text_[at_] != '=') refuse("an attribute has no value");
    ++at_;
    skip_space();
    if (at_ >= text_.size() || (text_[at_] != '"' && text_[at_] != '\''))
      refuse("an attribute's value has no quotes");
    const std::size_t close = text_.find(text_[at_], at_ + 1);
    if (close == std::string_view::npos) refuse("an attribute's value has no end");
    tag.attributes[attribute] = unescaped(text_.substr(at_ + 1, close - at_ - 1));
    at_ = close + 1;
  }
  ++at_;
  return tag;
}

std::string_view XmlReader::text_here() const {
  const std::size_t stop = text_.find('<', at_);
  return text_.substr(at_, stop == std::string_view::npos ? std::string_view::npos : stop - at_);
}

std::string xml_escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\n':
        result += "&#10;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

}  // namespace vol::io
