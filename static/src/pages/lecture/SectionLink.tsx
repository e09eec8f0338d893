import { LESSONS, type LessonId } from "./lessons";

/** "section 4", as a link to it: the number is that of the section's place now. */
export function SectionLink({ to, capital = false }: { readonly to: LessonId; readonly capital?: boolean }) {
  const number = LESSONS.findIndex(({ id }) => id === to) + 1;
  return (
    <a href={`#${to}`}>
      {capital ? "Section" : "section"} {number}
    </a>
  );
}
