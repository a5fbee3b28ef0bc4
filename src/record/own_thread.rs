//! Runs a recorder on a separate thread, so that the steps do not wait for it.
//!
//! Frames are copied into a fixed number of recycled buffers, which go to the thread and return once recorded. The
//! queue is therefore bounded, a run that is ahead of its recorder waits, no frame is dropped, and nothing is allocated
//! once the copies have grown. The recorder receives the same frames in the same order as on the stepping thread.

use crate::mechanics::tensor::Vec3;
use crate::plan::{FIELD_COPIES, FRAME_COPIES, Plan};
use crate::step::{FieldCopy, Frame, FrameCopy, Outcome, Recorder, RecorderError};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::Builder;

/// Orders to the thread.
enum Order {
    Start,
    Record(Box<FrameCopy>),
    Finish(Box<Outcome>),
}

/// Reply to each order, returning the copy.
struct Done {
    result: Result<(), RecorderError>,
    copy: Option<Box<FrameCopy>>,
}

/// Calls `run` with a recorder that forwards to `recorder` on a separate thread, which ends with the call.
///
/// Errors of `recorder` are reported with one of the next frames, or at the end.
///
/// # Panics
/// If `recorder` panicked, with its panic.
pub fn on_own_thread<T>(
    plan: &Plan,
    recorder: &mut (dyn Recorder + Send),
    run: impl FnOnce(&mut dyn Recorder) -> T,
) -> T {
    std::thread::scope(|scope| {
        let (orders, received) = sync_channel(FRAME_COPIES);
        // Capacity for every reply, so that the thread never waits for the run: only the run waits, for a copy.
        let (answers, done) = sync_channel(FRAME_COPIES + 1);
        let thread = Builder::new()
            .name("recorder".into())
            .spawn_scoped(scope, move || serve(plan, recorder, &received, &answers));
        let mut handle = Handle {
            orders,
            done,
            copies: (0..FRAME_COPIES).map(|_| Box::new(FrameCopy::new(plan))).collect(),
            fields: (0..FIELD_COPIES).map(|_| Box::new(FieldCopy::new(plan))).collect(),
        };
        let result = run(&mut handle);
        drop(handle);
        // If the system provided no thread, its channels are closed, and the run has failed for that reason.
        if let Ok(Err(panic)) = thread.map(std::thread::ScopedJoinHandle::join) {
            std::panic::resume_unwind(panic);
        }
        result
    })
}

/// The thread: executes orders until the handle is dropped. After a failure frames are accepted and discarded.
fn serve(plan: &Plan, recorder: &mut dyn Recorder, orders: &Receiver<Order>, answers: &SyncSender<Done>) {
    let (mut u, mut has_failed) = (vec![Vec3::zeros(); plan.node_count()], false);
    for order in orders {
        let (result, copy) = match order {
            Order::Start => (recorder.start(plan), None),
            Order::Record(copy) if has_failed => (Ok(()), Some(copy)),
            Order::Record(mut copy) => (recorder.record(&copy.frame(plan, &mut u)), Some(copy)),
            Order::Finish(outcome) => (recorder.finish(plan, &outcome), None),
        };
        has_failed |= result.is_err();
        if answers.send(Done { result, copy }).is_err() {
            return;
        }
    }
}

/// The recorder seen by the run.
#[allow(clippy::vec_box)] // they travel through the queues as they are
struct Handle {
    orders: SyncSender<Order>,
    done: Receiver<Done>,
    /// Copies available for the next frames.
    copies: Vec<Box<FrameCopy>>,
    fields: Vec<Box<FieldCopy>>,
}

impl Handle {
    fn order(&self, order: Order) -> Result<(), RecorderError> {
        self.orders.send(order).map_err(|_| gone())
    }

    /// Waits until all orders are completed; returns the first failure among them.
    fn wait_for_all(&mut self) -> Result<(), RecorderError> {
        let mut result = Ok(());
        loop {
            let done = self.done.recv().map_err(|_| gone())?;
            let is_last = done.copy.is_none();
            let found = self.take_back(done);
            result = result.and(found);
            if is_last {
                return result;
            }
        }
    }

    fn take_back(&mut self, done: Done) -> Result<(), RecorderError> {
        if let Some(mut copy) = done.copy {
            self.fields.extend(copy.take_field());
            self.copies.push(copy);
        }
        done.result
    }

    /// A copy to fill, with memory for the fields if requested; waits for one if all are in use.
    #[allow(clippy::type_complexity)] // a pair of what the caller requested
    fn free_copy(
        &mut self,
        with_field: bool,
    ) -> Result<(Box<FrameCopy>, Option<Box<FieldCopy>>), RecorderError> {
        while let Ok(done) = self.done.try_recv() {
            self.take_back(done)?;
        }
        loop {
            if !(self.copies.is_empty() || with_field && self.fields.is_empty())
                && let Some(copy) = self.copies.pop()
            {
                return Ok((copy, if with_field { self.fields.pop() } else { None }));
            }
            let done = self.done.recv().map_err(|_| gone())?;
            self.take_back(done)?;
        }
    }
}

/// The thread has ended early; the panic that ended it is propagated when the run has ended.
fn gone() -> RecorderError {
    RecorderError("the recording thread has ended".into())
}

impl Recorder for Handle {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        self.order(Order::Start)?;
        self.wait_for_all()
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let (mut copy, field) = self.free_copy(frame.is_look_time)?;
        copy.take(frame, field);
        self.order(Order::Record(copy))
    }

    fn finish(&mut self, _: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        self.order(Order::Finish(Box::new(outcome.clone())))?;
        self.wait_for_all()
    }
}
