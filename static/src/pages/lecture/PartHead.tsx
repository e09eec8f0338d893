import "./partHead.css";
import type { Part } from "./lessons";

interface PartHeadProps {
  /** Its place among the parts, from 1. */
  readonly number: number;
  readonly part: Part;
}

/** The heading of a part, with its sections. */
export function PartHead({ number, part: { title, sentence, lessons } }: PartHeadProps) {
  return (
    <nav class="part-head no-print" aria-label={`Part ${number}: ${title}`}>
      <p class="part-number">Part {number}</p>
      <p class="part-title">{title}</p>
      <p>{sentence}</p>
      <ol start={(lessons[0]?.index ?? 0) + 1}>
        {lessons.map(({ id, title: name }) => (
          <li key={id}>
            <a href={`#${id}`}>{name}</a>
          </li>
        ))}
      </ol>
    </nav>
  );
}
