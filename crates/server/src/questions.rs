//! A client's requests about plans: one of each kind is processed at a time, and of those that arrive meanwhile only
//! the newest is kept.

use std::future::{Future, pending};
use std::pin::Pin;

use axum::extract::ws::Utf8Bytes;

/// Computation of an answer.
type Answer = Pin<Box<dyn Future<Output = Utf8Bytes> + Send + Sync>>;

/// A queue for one kind of request that keeps only the newest waiting one.
#[derive(Default)]
struct LatestWins {
    under_way: Option<Answer>,
    next: Option<Answer>,
}

impl LatestWins {
    fn ask(&mut self, answer: Answer) {
        if self.under_way.is_none() {
            self.under_way = Some(answer);
        } else {
            self.next = Some(answer);
        }
    }

    /// Next answer; pending while there is no request. Cancellation safe.
    async fn answered(&mut self) -> Utf8Bytes {
        let Some(answer) = &mut self.under_way else { return pending().await };
        let text = answer.await;
        self.under_way = self.next.take();
        text
    }
}

/// Requests of one client.
#[derive(Default)]
pub struct Questions {
    assessments: LatestWins,
    ways: LatestWins,
}

impl Questions {
    /// Queues an assessment, which may take a while.
    pub fn ask_assessment(&mut self, answer: impl Future<Output = Utf8Bytes> + Send + Sync + 'static) {
        self.assessments.ask(Box::pin(answer));
    }

    /// Queues a route, which does not wait for assessments.
    pub fn ask_way(&mut self, answer: impl Future<Output = Utf8Bytes> + Send + Sync + 'static) {
        self.ways.ask(Box::pin(answer));
    }

    /// Next answer of either kind; pending while there is no request.
    pub async fn answered(&mut self) -> Utf8Bytes {
        tokio::select! {
            text = self.ways.answered() => text,
            text = self.assessments.answered() => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::future::ready;

    use tokio::sync::oneshot;

    use super::*;

    #[tokio::test]
    async fn of_those_that_wait_the_newest_is_answered_and_a_way_waits_for_no_assessment() {
        let mut questions = Questions::default();
        let text = Utf8Bytes::from_static;
        let (done, flown) = oneshot::channel();
        questions.ask_assessment(async { flown.await.expect("an answer") });
        questions.ask_assessment(ready(text("superseded")));
        questions.ask_assessment(ready(text("second")));
        questions.ask_way(ready(text("way")));
        assert_eq!(questions.answered().await, text("way"));
        done.send(text("first")).expect("it is waited for");
        assert_eq!(questions.answered().await, text("first"));
        assert_eq!(questions.answered().await, text("second"));
        assert!(tokio::time::timeout(std::time::Duration::ZERO, questions.answered()).await.is_err());
    }
}
