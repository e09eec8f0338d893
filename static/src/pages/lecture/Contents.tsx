import "./contents.css";
import { LESSONS } from "./lessons";

/** The list of all lessons; `page` is the address of the lecture where this stands on another page. */
export function Contents({ page = "" }: { page?: string }) {
  return (
    <nav class="contents" aria-label="Sections of the lecture">
      <ol>
        {LESSONS.map(({ id, title }) => (
          <li key={id}>
            <a href={`${page}#${id}`}>{title}</a>
          </li>
        ))}
      </ol>
    </nav>
  );
}
