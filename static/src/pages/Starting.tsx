import { computed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { countSayers, isStalled } from "../ui/browser/awaited";
import { Working } from "../ui/Working";
import { NO_ANSWER } from "../wire/ask";
import { starting } from "./worldSession";

/** Longer than a start takes if the server has compiled its functions. */
const COMPILING_AFTER_S = 2;

/** Whether a start takes long, or the server does not answer. */
export const isDelayed = computed(() => {
  const work = starting.value;
  return work !== null && (isStalled.value || work.elapsed_s > COMPILING_AFTER_S);
});

interface StartingProps {
  /** A sentence on what works without the server. The note then covers its container instead of a corner. */
  readonly meanwhile?: string;
  /** Another problem of the page; null if there is none. */
  readonly trouble?: string | null;
}

/** A note shown while the server creates a new world or does not answer. */
export function Starting({ meanwhile, trouble = null }: StartingProps) {
  useEffect(() => {
    countSayers(1);
    return () => {
      countSayers(-1);
    };
  }, []);
  const work = starting.value;
  const problem = trouble ?? (work && isStalled.value ? NO_ANSWER : null);
  const isInside = meanwhile !== undefined;
  if (problem)
    return (
      <div class={isInside ? "working-place inside" : "working-place"} role="status">
        <p class="working">
          {problem} {meanwhile}
        </p>
      </div>
    );
  const isCompiling = work !== null && work.elapsed_s > COMPILING_AFTER_S;
  return (
    <Working
      what={isCompiling ? "The first start on a server compiles the mapping functions" : "Starting the simulation"}
      work={work}
      isInside={isInside}
    />
  );
}
