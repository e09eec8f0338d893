import { expect, test } from "vitest";
import { yamlOf } from "./Messages";

test("a message is written as ros2 topic echo writes it", () => {
  const message = {
    header: { stamp: { sec: 3, nanosec: 5 }, frame_id: "laser" },
    ranges: [1.5, ".inf", "… 718 more"],
    transforms: [
      { child: "base", x: 1 },
      { child: "odom", x: -2 },
    ],
    none: [],
    big: "1152921504606846977",
    text: "12",
    flag: true,
    "a: b": { c: 1 },
  };
  expect(yamlOf(message)).toBe(`header:
  stamp:
    sec: 3
    nanosec: 5
  frame_id: "laser"
ranges:
  - 1.5
  - .inf
  - "… 718 more"
transforms:
  - child: "base"
    x: 1
  - child: "odom"
    x: -2
none: []
big: 1152921504606846977
text: "12"
flag: true
"a: b":
  c: 1
`);
});
