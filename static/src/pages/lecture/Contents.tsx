import "./contents.css";
import { LECTURE_PARTS } from "./lessons";

/** The parts of the lecture, each a link to its first section, for other pages. */
export function Contents() {
  return (
    <nav class="contents" aria-label="Parts of the lecture">
      {LECTURE_PARTS.map(({ title, sentence, lessons }) => (
        <a key={title} href={`/lecture.html#${lessons[0]?.id}`}>
          <b>{title}</b>
          <span>{sentence}</span>
        </a>
      ))}
    </nav>
  );
}
